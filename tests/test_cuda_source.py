"""Every kernel compiles for graphics cards, also on machines that have none (Warp brings NVRTC)."""

import importlib
import pkgutil

import pytest
import warp as wp
from law_checks import PLAIN, SPACING, crimp_table, fabric

from warpdrape import kernels
from warpdrape.forces.hypoelastic import _kernels
from warpdrape.forces.membrane import _yarn_kernels
from warpdrape.forces.sliding_chains import _made
from warpdrape.kernels.forces import sheet
from warpdrape.kernels.forces.bending import add_bending_forces
from warpdrape.kernels.forces.objective_rates import fibre_rows, polar_rows
from warpdrape.kernels.forces.ties import add_tie_forces
from warpdrape.materials.law_data import membrane_functions
from warpdrape.materials.laws import LinearTension, ShearPolynomial, ShearTable

ARCHITECTURE = 80
"""Of the NVIDIA A100."""

TENSIONS = {
    "linear": (LinearTension(46e3, 48e3), None),
    "crimp": (PLAIN, (SPACING, SPACING)),
    "tabulated": (crimp_table(), (SPACING, SPACING)),
}
SHEARS = {
    "polynomial": ShearPolynomial((4e-4,)),
    "table": ShearTable((0.0, 0.5, 1.0), (0.0, 1e-4, 5e-4)),
}

pytestmark = pytest.mark.skipif(
    ARCHITECTURE not in (wp.get_cuda_supported_archs() or []), reason="no compiler for CUDA here"
)


def modules_of_kernels():
    """Files of kernels; those of functions alone are compiled with the kernels they serve."""
    found = pkgutil.walk_packages(kernels.__path__, f"{kernels.__name__}.")
    names = [module.name for module in found if not module.ispkg]
    return [name for name in names if importlib.import_module(name) and wp.get_module(name).kernels]


def compiled(module, folder):
    """Bytes of PTX; compiling raises where the kernels are at fault."""
    (path,) = wp.compile_aot_module(module, arch=ARCHITECTURE, module_dir=folder, use_ptx=True)
    assert path.suffix == ".ptx"
    return path.stat().st_size


@pytest.mark.parametrize("name", modules_of_kernels())
def test_the_kernels_of_a_file_compile(name, tmp_path):
    assert compiled(wp.get_module(name), tmp_path) > 1000


def test_there_are_kernels_to_compile():
    assert {"pressure", "motion", "selective_mass", "tool_contact", "ply_contact"} <= {
        name.rpartition(".")[2] for name in modules_of_kernels()
    }


@pytest.mark.parametrize("tension", TENSIONS)
@pytest.mark.parametrize("shear", SHEARS)
def test_the_kernels_of_every_pair_of_laws_compile(tension, shear, tmp_path):
    law, cell = TENSIONS[tension]
    cloth = fabric(law, SHEARS[shear], **({"cell": cell} if cell else {}))
    for number, kernel in enumerate(_yarn_kernels(membrane_functions(cloth))):
        assert compiled(kernel.module, tmp_path / str(number)) > 1000


@pytest.mark.parametrize("rows", [fibre_rows, polar_rows])
def test_the_kernels_of_stress_as_a_state_compile(rows, tmp_path):
    tension, _, shear, _, *structs = membrane_functions(fabric(*TENSIONS["linear"][:1]))
    for number, kernel in enumerate(_kernels(rows, tension, shear, *structs, True)):
        assert compiled(kernel.module, tmp_path / str(number)) > 1000


@pytest.mark.parametrize("tension", TENSIONS)
def test_the_kernels_of_yarns_that_slide_compile(tension, tmp_path):
    law, cell = TENSIONS[tension]
    cloth = fabric(law, SHEARS["polynomial"], **({"cell": cell} if cell else {}))
    pull, energy, _, _, struct, _ = membrane_functions(cloth)
    made = _made(pull, energy, struct)
    for kernel in (made.pull, made.slide, made.measure_bars, made.measure_slides):
        assert compiled(kernel.module, tmp_path / kernel.key) > 1000


def test_the_kernel_of_bending_compiles(tmp_path):
    assert compiled(add_bending_forces.module, tmp_path) > 1000


def test_the_kernel_of_ties_compiles(tmp_path):
    assert compiled(add_tie_forces.module, tmp_path) > 1000


@pytest.mark.parametrize("kernel", [sheet.add_isotropic_forces, sheet.add_rubber_forces])
def test_the_kernels_of_sheets_without_yarns_compile(kernel, tmp_path):
    assert compiled(kernel.module, tmp_path) > 1000
