"""Seeds for passes whose random numbers never coincide."""

import numpy as np

BLOCK = 32
"""Side of the blocks in which scalar variants render [pixels]; smaller with many threads."""


class PassSeeds:
    """Mitsuba's seed for each pass of a run, or of a reference.

    The scalar variants seed the sampler of each pixel with `seed · width · height + pixel`: two
    seeds give the same image wherever these products agree modulo 2³², such as 0 and 65536 at
    256 × 256. So only `2³² / pixels` seeds are different at all. Runs have the first half of them,
    references the second, so that no error is measured against the random numbers that made it.

    Seeds at equal distances give passes that are not independent: the variance of a mean over 32
    consecutive ones at 24 × 16 is 1.25 times what their spread says. So each half is shuffled, in
    an order that never changes, as a reference that goes on relies on it. A run with seed S takes
    consecutive ones of that order, starting at the fraction that the van der Corput sequence gives
    for S: few runs are as far apart as possible.

    A reference may need many: where the variant is not scalar, Mitsuba hashes seeds, and the half
    of all 2³² is there for it.
    """

    def __init__(
        self, seed: int, width: int, height: int, *, reference: bool = False, scalar: bool = True
    ) -> None:
        self.capacity = self._first = 2**31
        """How many passes have a seed of their own."""
        self._stride = 1
        self._order: np.ndarray | None = None
        if scalar or not reference:
            pixels = width * height
            blocks = -(-width // BLOCK) * -(-height // BLOCK)
            # Blocks at the border are numbered as if they were whole.
            self._stride = -(-blocks * BLOCK * BLOCK // pixels)
            self.capacity = max(1, 2**32 // (pixels * self._stride) // 2)
            self._first = self.capacity if reference else 0
            # The legacy generator is the one whose numbers are promised to stay.
            self._order = np.random.RandomState(0).permutation(self.capacity)
        reversed_bits = int(f"{seed % 2**32:032b}"[::-1], 2)
        self._start = reversed_bits * self.capacity >> 32

    def __call__(self, index: int) -> int:
        """Seed for the pass with this index, from 0."""
        place = (self._start + index) % self.capacity
        shuffled = place if self._order is None else int(self._order[place])
        return (self._first + shuffled) * self._stride
