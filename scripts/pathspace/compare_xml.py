"""Compares our image of a Mitsuba scene with Mitsuba's of the same file, and with another one.

    PYTHONPATH=scripts .venv/bin/python -m pathspace.compare_xml SCENE.xml -D integrator=path

Blocks of pixels are compared by z = (ours - theirs) / sqrt(variances), where each renderer's own
independent passes give the variance. A block differs where |z| is beyond the quantile of Student's
t of 0.1 % for all blocks and channels together (Bonferroni), with the degrees of freedom of one
renderer alone, as if the other had no noise. The root mean square of z shows whether tails of
unlikely paths make it wider than normal.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np

from .exr import Image, read_channels, rgb

SIGNIFICANCE = 1e-3


@dataclass
class Estimate:
    """Blocks of an image with the variance of each, and of the mean of all pixels."""

    blocks: Image
    variances: Image
    passes: int


def into_blocks(image: Image, block: int) -> Image:
    """Sums over squares of pixels; what does not fill one at the right and bottom is left out."""
    height, width = (size // block * block for size in image.shape[:2])
    image = image[:height, :width].astype(np.float64)
    return image.reshape(height // block, block, width // block, block, -1).sum(axis=(1, 3))


def ours(arguments: argparse.Namespace, scene: Path, passes: int) -> Estimate:
    """Independent renders of ours."""
    images = []
    definitions = [f"-D{definition}" for definition in arguments.define]
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(arguments.seed, arguments.seed + passes):
            image = Path(folder) / "image.exr"
            command = [arguments.binary, "render", scene, "-o", image, *definitions]
            command += ["-i", arguments.integrator, f"--spp={arguments.spp}", f"--seed={seed}"]
            subprocess.run(command, check=True, capture_output=True)
            found = rgb(read_channels(image))
            assert found is not None
            images.append(into_blocks(found, arguments.block))
    return estimate(images)


def theirs(arguments: argparse.Namespace, scene: Path, passes: int, first: int) -> Estimate:
    """Independent renders of Mitsuba's `path`, of the file as it is."""
    parameters = dict(definition.split("=", 1) for definition in arguments.define)
    loaded = mi.load_file(str(scene), **parameters)
    images = []
    for seed in range(first, first + passes):
        image = np.array(mi.render(loaded, spp=arguments.spp, seed=seed))[..., :3]
        images.append(into_blocks(image, arguments.block))
    return estimate(images)


def estimate(images: list[Image]) -> Estimate:
    """Mean and its variance from independent images."""
    stack = np.stack(images)
    return Estimate(stack.mean(axis=0), stack.var(axis=0, ddof=1) / len(images), len(images))


def student(significance: float, freedom: int) -> float:
    """The t beyond which lies this share of both tails; odd degrees of freedom count one less.

    Abramowitz and Stegun, 26.7.4.
    """
    freedom = max(2, freedom // 2 * 2)

    def inside(t: float) -> float:
        angle = math.atan(t / math.sqrt(freedom))
        term = total = 1.0
        for i in range(1, freedom // 2):
            term *= (2 * i - 1) / (2 * i) * math.cos(angle) ** 2
            total += term
        return math.sin(angle) * total

    low, high = 0.0, 1e6
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if 1 - inside(middle) > significance else (low, middle)
    return high


def compare(name: str, a: Estimate, b: Estimate) -> bool:
    """Prints how far two images are apart; true where no block differs."""
    variances = a.variances + b.variances
    lit = variances > 0
    z = (a.blocks - b.blocks)[lit] / np.sqrt(variances[lit])
    limit = student(SIGNIFICANCE / max(z.size, 1), min(a.passes, b.passes) - 1)
    total, other = a.blocks.sum(), b.blocks.sum()
    error = np.sqrt(variances.sum()) / other
    worst = float(np.abs(z).max()) if z.size else 0.0
    dark = int(((a.blocks != b.blocks) & ~lit).sum())
    agree = worst < limit and dark == 0
    told = [
        f"mean {total / other - 1:+.3%} with a standard error of {error:.3%}",
        f"{z.size} blocks, rms z {np.sqrt(np.mean(z**2)):.3f}",
        f"|z| at most {worst:.2f} (limit {limit:.2f})",
        f"{dark} differ without noise",
    ]
    print(f"{name}: {', '.join(told)}: {'agree' if agree else 'DIFFER'}")
    return agree


def main() -> None:
    """Compares one scene."""
    layout = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=layout)
    parser.add_argument("scene", type=Path, help="an XML scene")
    parser.add_argument("--binary", type=Path, default=Path("target/release/pathspace"))
    parser.add_argument("--integrator", default="path", help="of ours")
    parser.add_argument("-D", dest="define", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel of a pass")
    parser.add_argument("--passes", type=int, default=16, help="passes of each renderer")
    parser.add_argument("--seed", type=int, default=1, help="of the first pass")
    parser.add_argument("--block", type=int, default=16, help="side of a block in pixels")
    parser.add_argument("--export", action="store_true", help="Mitsuba renders our export too")
    parser.add_argument("--image", type=Path, help="another image, compared by its mean")
    arguments = parser.parse_args()
    mi.set_variant("llvm_ad_rgb" if "llvm_ad_rgb" in mi.variants() else "scalar_rgb")
    mine = ours(arguments, arguments.scene, arguments.passes)
    original = theirs(arguments, arguments.scene, arguments.passes, arguments.seed)
    agree = compare("ours against Mitsuba", mine, original)
    if arguments.export:
        with tempfile.TemporaryDirectory() as folder:
            command = [arguments.binary, "export", arguments.scene, folder]
            command += [f"-D{definition}" for definition in arguments.define]
            subprocess.run(command, check=True, capture_output=True)
            arguments.define = []
            exported = theirs(
                arguments, Path(folder) / "scene.xml", arguments.passes, arguments.seed + 1000
            )
        agree &= compare("export against original, both by Mitsuba", exported, original)
    if arguments.image:
        image = rgb(read_channels(arguments.image))
        assert image is not None
        pixels = mine.blocks[..., 0].size * arguments.block**2
        mean, other = mine.blocks.sum() / (3 * pixels), image.mean(dtype=np.float64)
        print(f"mean of ours {mean:.6f}, of {arguments.image} {other:.6f}: {mean / other - 1:+.2%}")
        agree &= bool(abs(mean / other - 1) < 0.03)
    raise SystemExit(0 if agree else 1)


if __name__ == "__main__":
    main()
