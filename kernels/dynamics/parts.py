"""What threads of the CPU share when each computes a part of the model: a barrier, and sums.

Warp's atomic operations are plain ones on the CPU, so that no two parts may write the same entry:
each scatters into arrays of its own, and whoever owns an entry adds up what the others have there.
"""

import warp as wp

LINE = 16
"""Integers from one counter to the next: a cache line each, else threads would slow each other."""


@wp.func_native(
    """
#if !defined(__CUDACC__)
    int* mine = arrived.data + LINE * part;
    int target = *mine + 1;
    __atomic_store_n(mine, target, __ATOMIC_RELEASE);
    for (int other = 0; other < parts; ++other) {
        int* theirs = arrived.data + LINE * other;
        int spun = 0;
        while (__atomic_load_n(theirs, __ATOMIC_ACQUIRE) < target) {
            if (__atomic_load_n(arrived.data + LINE * parts, __ATOMIC_RELAXED)) return;
            if (++spun <= spins) {
#if defined(__x86_64__)
                __builtin_ia32_pause();
#endif
            } else if (give_way) {
                reinterpret_cast<void (*)()>(give_way)();
            }
        }
    }
#endif
""".replace("LINE", str(LINE))
)
def wait_for_parts(
    part: int, parts: int, spins: int, give_way: wp.uint64, arrived: wp.array(dtype=wp.int32)
):
    """Wait until every part has come here as often as this one; see `await_parts`."""
    ...


@wp.kernel(enable_backward=False)
def await_parts(
    part: int, parts: int, spins: int, give_way: wp.uint64, arrived: wp.array(dtype=wp.int32)
):
    """Barrier; one thread in all, launched once by every part. On the CPU only.

    Args:
        part: number of the part that arrives.
        parts: how many there are.
        spins: looks at a counter before the processor is offered to others at each further one.
        give_way: address of the system's function that offers it, 0 if there is none.
        arrived: how often each part has come to a barrier, ``LINE`` apart; after them, anything but
            zero where nobody is to wait any more; shape [(parts + 1) · LINE].
    """
    wait_for_parts(part, parts, spins, give_way, arrived)


@wp.func_native(
    """
#if !defined(__CUDACC__)
    double* from = reinterpret_cast<double*>(theirs.data + first);
    double* to = reinterpret_cast<double*>(ours.data + first);
    const int size = 3 * count, group = 24;
    for (int k = 0; k < size; k += group) {
        const bool whole = k + group <= size;
        unsigned long long bits[group], any = whole ? 0 : 1;
        if (whole) {
            __builtin_memcpy(bits, from + k, sizeof(bits));
            for (int i = 0; i < group; ++i) any |= bits[i];
        }
        if (!any) continue;
        const int end = whole ? k + group : size;
        for (int i = k; i < end; ++i) {
            to[i] += from[i];
            from[i] = 0.0;
        }
    }
#endif
"""
)
def add_run(
    first: int, count: int, theirs: wp.array(dtype=wp.vec3d), ours: wp.array(dtype=wp.vec3d)
):
    """Add a run of entries and clear it; see `take_over`."""
    ...


@wp.kernel(enable_backward=False)
def take_over(
    first: int, count: int, theirs: wp.array(dtype=wp.vec3d), ours: wp.array(dtype=wp.vec3d)
):
    """Add entries of another part to ours and clear them; one thread in all. On the CPU only.

    The compiler makes vector instructions of the plain loop. Most entries are zero, as parts meet
    only at their borders: groups of eight that are zero cost no more than a look.

    Args:
        first: number of the first entry.
        count: how many there are.
        theirs: any unit; cleared.
        ours: accumulated.
    """
    add_run(first, count, theirs, ours)


@wp.kernel(enable_backward=False)
def take_over_each(
    first: int, theirs: wp.array(dtype=wp.float64), ours: wp.array(dtype=wp.float64)
):
    """Add entries of another part to ours and clear them; one thread an entry.

    Args:
        first: number of the first entry.
        theirs: any unit; cleared.
        ours: accumulated.
    """
    i = first + wp.tid()
    ours[i] += theirs[i]
    theirs[i] = wp.float64(0.0)


@wp.kernel(enable_backward=False)
def raise_to(theirs: wp.array(dtype=wp.float64), ours: wp.array(dtype=wp.float64)):
    """Raise our entries to those of another part; one thread an entry."""
    i = wp.tid()
    ours[i] = wp.max(ours[i], theirs[i])


@wp.kernel(enable_backward=False)
def note_runaway(theirs: wp.array(dtype=wp.int32), ours: wp.array(dtype=wp.int32)):
    """Take another part's first runaway vertex where we have none; one thread in all."""
    if ours[0] < 0:
        ours[0] = theirs[0]
