"""Sweeps: threads that go through many entries each.

Before its first line, every thread of a Warp kernel on a processor reads and stores all arguments:
5 to 60 ns with the structs of a contact, more than most vertices cost that touch nothing. So there
one thread goes through all entries; on a card each has one.
"""

import warp as wp


@wp.struct
class Sweep:
    """Entries of a launch: a thread goes on from its first one by as many as there are threads."""

    first: wp.int32
    end: wp.int32  # number after the last
    threads: wp.int32
