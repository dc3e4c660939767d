"""Four numbers or vectors at a time, in the lanes of ``vec4d``: what a CPU computes at once.

Written lane by lane, Warp's compiler makes one instruction of four; `WIDE` are the flags it needs.
"""

import warp as wp

WIDE = {
    "cpu_compiler_flags": "-march=native -ffp-contract=fast"
    " -mllvm=-inline-threshold=9000 -mllvm=-inline-cold-callsite-threshold=3000"
    " -mllvm=-slp-recursion-max-depth=12 -mllvm=-slp-vectorize-hor-store"
}
"""Module options: Warp's own flags, but fused multiply-add, and lanes looked for more deeply.

Neither assumes that numbers are finite, nor reorders sums.
"""


@wp.struct
class Vectors:
    """Four vectors, component by component."""

    x: wp.vec4d
    y: wp.vec4d
    z: wp.vec4d


@wp.func
def vectors(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, d: wp.vec3d) -> Vectors:
    """Put four vectors side by side."""
    out = Vectors()
    out.x = wp.vec4d(a[0], b[0], c[0], d[0])
    out.y = wp.vec4d(a[1], b[1], c[1], d[1])
    out.z = wp.vec4d(a[2], b[2], c[2], d[2])
    return out


@wp.func
def lane(u: Vectors, i: int) -> wp.vec3d:
    """Vector number i."""
    return wp.vec3d(u.x[i], u.y[i], u.z[i])


@wp.func
def difference(u: Vectors, v: Vectors) -> Vectors:
    """Return u − v."""
    out = Vectors()
    out.x = u.x - v.x
    out.y = u.y - v.y
    out.z = u.z - v.z
    return out


@wp.func
def combination(p: wp.vec4d, u: Vectors, q: wp.vec4d, v: Vectors) -> Vectors:
    """Return p u + q v."""
    out = Vectors()
    out.x = wp.cw_mul(p, u.x) + wp.cw_mul(q, v.x)
    out.y = wp.cw_mul(p, u.y) + wp.cw_mul(q, v.y)
    out.z = wp.cw_mul(p, u.z) + wp.cw_mul(q, v.z)
    return out


@wp.func
def dots(u: Vectors, v: Vectors) -> wp.vec4d:
    """Return u · v."""
    return wp.cw_mul(u.x, v.x) + wp.cw_mul(u.y, v.y) + wp.cw_mul(u.z, v.z)


@wp.func
def roots(q: wp.vec4d) -> wp.vec4d:
    """Return √q."""
    return wp.vec4d(wp.sqrt(q[0]), wp.sqrt(q[1]), wp.sqrt(q[2]), wp.sqrt(q[3]))


@wp.func
def inverses(q: wp.vec4d) -> wp.vec4d:
    """Return 1/q."""
    one = wp.float64(1.0)
    return wp.vec4d(one / q[0], one / q[1], one / q[2], one / q[3])


@wp.func
def larger(p: wp.vec4d, q: wp.vec4d) -> wp.vec4d:
    """Return the larger of p and q."""
    return wp.vec4d(wp.max(p[0], q[0]), wp.max(p[1], q[1]), wp.max(p[2], q[2]), wp.max(p[3], q[3]))


@wp.func
def pair_sums(q: wp.vec4d) -> wp.vec4d:
    """Sums of lanes 0 and 1, and of lanes 2 and 3, in both of their lanes."""
    return wp.vec4d(q[0] + q[1], q[0] + q[1], q[2] + q[3], q[2] + q[3])


@wp.func
def of_pairs(p: wp.float64, q: wp.float64) -> wp.vec4d:
    """Put p in lanes 0 and 1, q in lanes 2 and 3."""
    return wp.vec4d(p, p, q, q)
