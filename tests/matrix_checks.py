"""Viscosities and shifts with temperature that tests of the matrix share."""

from warpdrape.laws import WLF, Arrhenius, Cross, Newtonian, PowerLaw

LAWS = {
    "newtonian": Newtonian(2e5),
    "power": PowerLaw(1e6, 0.45, 0.1, 0.01),
    "cross": Cross(4e6, 2e4, 30.0, 0.7),
    "cross, m = 1": Cross(4e6, 0.0, 30.0, 1.0),
}
SHIFTS = {
    "arrhenius": Arrhenius(
        activation_energy=6e4, reference_temperature=533.0, lowest_temperature=463.0
    ),
    "wlf": WLF(c1=4.0, c2=150.0, reference_temperature=533.0, lowest_temperature=463.0),
}
