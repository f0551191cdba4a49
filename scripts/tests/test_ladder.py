import numpy as np
import pytest

from pathspace.ladder import Ladder, Timed, block_means, calibrate, invalid_pixels, passes_for
from pathspace.seeds import BLOCK, PassSeeds


def image(value: float) -> np.ndarray:
    return np.full((5, 7, 3), value, np.float32)


def test_the_mean_weighs_passes_by_their_samples() -> None:
    ladder = Ladder(block=4)
    ladder.add(Timed(image(1.0), 0.1, 0.2), 3)
    ladder.add(Timed(image(5.0), 0.1, 0.2), 1)
    assert np.array_equal(ladder.mean(), image(2.0))
    assert (ladder.spp, ladder.seconds, ladder.cpu_seconds) == (4, 0.2, 0.4)


def test_a_pass_over_several_targets_is_the_last_of_their_checkpoints() -> None:
    ladder = Ladder(block=4, targets=[0.1, 0.2, 0.4, 5.0])
    assert ladder.add(Timed(image(0.0), 0.05, 0.0), 1) is None
    assert ladder.add(Timed(image(0.0), 0.40, 0.0), 1) == 2
    assert ladder.add(Timed(image(0.0), 0.05, 0.0), 1) is None


def test_block_means_add_up_to_the_mean_of_the_image() -> None:
    picture = np.random.default_rng(1).random((37, 50, 3)).astype(np.float32)
    means = block_means(picture, 16)
    assert means.shape == (3, 4, 3)
    areas = np.outer([16, 16, 5], [16, 16, 16, 2])[:, :, None]
    total = picture.astype(np.float64).sum(axis=(0, 1))
    assert np.allclose((means * areas).sum(axis=(0, 1)), total, rtol=1e-13)
    assert np.allclose(means[2, 3], picture[32:, 48:].mean(axis=(0, 1), dtype=np.float64))


def test_impossible_values_are_counted_by_pixel() -> None:
    picture = image(0.0)
    picture[0, 0] = np.nan
    picture[1, 2, 1] = -1e-9
    picture[3, 3, 2] = np.inf
    assert invalid_pixels(picture) == 3


@pytest.mark.parametrize("spp", [1, 7, 64, 100, 1009])
@pytest.mark.parametrize("pass_spp", [1, 8, 32])
def test_passes_add_up_exactly(spp: int, pass_spp: int) -> None:
    sizes = passes_for(spp, pass_spp)
    assert sum(sizes) == spp
    assert max(sizes) <= pass_spp
    assert len(set(sizes[:-1])) <= 1


def test_calibration_fills_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    compiled = set()

    def render(_seed: int, spp: int) -> np.ndarray:
        clock[0] += 0.001 + 0.0007 * spp + (0.0 if spp in compiled else 0.5)
        compiled.add(spp)
        return image(0.0)

    monkeypatch.setattr("time.perf_counter", lambda: clock[0])
    found = calibrate(render, 0.05)
    assert found.spp == 64
    assert found.setup_seconds == pytest.approx(0.5)


@pytest.mark.parametrize("size", [(256, 256), (96, 64), (33, 65), (1000, 1)])
def test_pixels_never_share_a_seed(size: tuple[int, int]) -> None:
    """The states `seed · pixels + pixel` of the scalar sampler, as intervals modulo 2³²."""
    width, height = size
    blocks = -(-width // BLOCK) * -(-height // BLOCK)
    starts = []
    for seed in range(4):
        passes = PassSeeds(seed, width, height)
        starts += [passes(index) * width * height % 2**32 for index in range(200)]
    reference = PassSeeds(3, width, height, reference=True)
    starts += [reference(index) * width * height % 2**32 for index in range(1000)]
    starts = sorted(starts)
    gaps = np.diff([*starts, starts[0] + 2**32])
    assert gaps.min() >= blocks * BLOCK * BLOCK


def test_no_seed_of_a_run_is_one_of_a_reference() -> None:
    run, kept = (PassSeeds(9, 512, 512, reference=reference) for reference in (False, True))
    assert run.capacity == kept.capacity == 8192
    seeds = [{seeds(index) for index in range(seeds.capacity)} for seeds in (run, kept)]
    assert len(seeds[0] | seeds[1]) == 2 * 8192
    hashed = PassSeeds(2**31 - 1, 512, 512, reference=True, scalar=False)
    assert hashed.capacity == 2**31
    assert 2**31 <= min(hashed(0), hashed(2**31 - 1)) <= max(hashed(0), hashed(2**31 - 1)) < 2**32
