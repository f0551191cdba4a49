"""Renders the reference image of a scene, and writes down how.

python -m pathspace.references SCENE_FOLDER --integrator bdpt --seconds 600 [--seed 1000]
                               [--state FILE.film]

Writes `reference.exr` beside the scene (channels R, G, B, and the estimated standard error of each
pixel as `standard_error.R` …) and `reference.toml`: method, samples, seed, version, and a summary
of the standard error. With `--state`, rendering goes on from that file if it is there.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import mitsuba
import numpy as np
from numpy.typing import NDArray

PROGRAM = Path(__file__).parents[2] / "target/release/pathspace"


def main() -> int:
    """Render, then describe."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("scene", type=Path, help="folder with scene.gltf")
    parser.add_argument("--integrator", default="bdpt")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--state", type=Path, help="film to go on from and to leave behind")
    options = parser.parse_args()
    image = options.scene / "reference.exr"
    command: list[str] = [str(PROGRAM), "render", str(options.scene), "-o", str(image)]
    command += ["--seconds", str(options.seconds)]
    if options.state and options.state.exists():
        command += ["--resume", str(options.state)]
    else:
        command += ["-i", options.integrator, "--seed", str(options.seed)]
        command += ["--state", str(options.state)] if options.state else []
    status = subprocess.run(command).returncode
    if status == 0:
        (options.scene / "reference.toml").write_text(provenance(image), encoding="utf-8")
    return status


def provenance(image: Path) -> str:
    """Say in TOML how the image was made and how certain it is."""
    mitsuba.set_variant("scalar_rgb")
    bitmap = mitsuba.Bitmap(str(image))
    names = [field.name for field in bitmap.struct_()]
    pixels = np.array(bitmap, dtype=np.float64)
    mean = pixels[..., [names.index(c) for c in "RGB"]]
    error = pixels[..., [names.index(f"standard_error.{c}") for c in "RGB"]]
    attributes = bitmap.metadata()
    lines = [
        "# How reference.exr was made. The standard error of each pixel is in its channels",
        "# standard_error.*; relative errors here are luminance over the image's mean.",
        f'method = "{attributes["integrator"]}"',
        f"settings = '{attributes['settings']}'",
        f"samples_per_pixel = {attributes['samplesPerPixel']}",
        f"seed = {attributes['seed']}",
        f"render_seconds = {float(attributes['renderSeconds']):.1f}",
        f'version = "{attributes["pathspaceVersion"]}"',
        "[relative_standard_error]",
    ]
    relative = luminance(error) / luminance(mean).mean()
    for name, quantile in [("median", 50), ("percentile_99", 99), ("largest", 100)]:
        lines.append(f"{name} = {np.percentile(relative, quantile):.3e}")
    lines.append(f"root_mean_square = {np.sqrt(np.mean(relative**2)):.3e}")
    return "\n".join(lines) + "\n"


def luminance(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weigh the channels by Rec. 709."""
    return image @ np.array([0.2126, 0.7152, 0.0722])


if __name__ == "__main__":
    sys.exit(main())
