"""The forces and contacts there are: a new one is listed here, and nowhere else."""

from __future__ import annotations

from warpdrape.contact import ply_contact, tool_contact
from warpdrape.forces import bending, bending_curve, membrane

FORCES = (membrane, bending, bending_curve)
"""Modules of forces: ``build``, and ``frequencies``, the bound on ω² of a ply's triangles.

The first one is what selective mass scaling scales, and its elements say how parts on several
threads share out a ply."""
CONTACTS = (ply_contact, tool_contact)
"""Modules of contacts: ``build``; what they take of the step is `contact.law.step_share`."""
