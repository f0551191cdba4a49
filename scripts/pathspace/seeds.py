"""Seeds for passes whose random numbers never coincide."""

BLOCK = 32
"""Side of the blocks in which scalar variants render [pixels]; smaller with many threads."""


class PassSeeds:
    """Mitsuba's seed for each pass of a run.

    The scalar variants seed the sampler of each pixel with `seed · width · height + pixel`: two
    seeds give the same image wherever these products agree modulo 2³², such as 0 and 65536 at
    256 × 256. So only `capacity = 2³² / pixels` seeds are different at all. A run with seed S takes
    consecutive ones, starting at the fraction of them that the van der Corput sequence gives for
    S: few runs are as far apart as possible.
    """

    def __init__(self, seed: int, width: int, height: int) -> None:
        pixels = width * height
        blocks = -(-width // BLOCK) * -(-height // BLOCK)
        # Blocks at the border are numbered as if they were whole.
        self._stride = -(-blocks * BLOCK * BLOCK // pixels)
        self.capacity = max(1, 2**32 // (pixels * self._stride))
        reversed_bits = int(f"{seed % 2**32:032b}"[::-1], 2)
        self._start = reversed_bits * self.capacity >> 32

    def __call__(self, index: int) -> int:
        """Seed for the pass with this index, from 0."""
        return (self._start + index) % self.capacity * self._stride
