"""An experiment that never took place, in the files of a real one."""

import csv
import json
from collections.abc import Iterable, Mapping
from pathlib import Path

import mitsuba
import numpy as np

METHODS = {
    "path": ("pathspace 0.1.0", 0.3),
    "light": ("pathspace 0.1.0", 0.5),
    "bdpt": ("pathspace 0.1.0", 0.2),
    "mitsuba:path": ("mitsuba 3.9.1 llvm_ad_rgb", 0.4),
    "mitsuba:ptracer": ("mitsuba 3.9.1 llvm_ad_rgb", 0.7),
}
HARDWARE = "A processor × 2"
SIZE = 24
SECONDS = np.geomspace(0.2, 10, 8)


def write_table(path: Path, lines: Iterable[Mapping[str, object]]) -> None:
    """Write a table of schema 1, numbers with all their digits."""
    lines = [{"schema": 1, **line} for line in lines]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, lines[0].keys())
        writer.writeheader()
        writer.writerows(lines)


def write_rows(
    folder: Path, scenes: list[str], seeds: int = 5, hardware: tuple[str, ...] = (HARDWARE,)
) -> None:
    """Errors that fall as the inverse square root of time, with some noise."""
    random = np.random.default_rng(7)
    lines = []
    for scene in scenes:
        for method, (renderer, level) in METHODS.items():
            for seed in range(seeds):
                for checkpoint, target in enumerate(SECONDS):
                    seconds = target * (1 + 0.1 * random.random())
                    rmse = level * seconds**-0.5 * np.exp(0.1 * random.normal())
                    lines.append(
                        {
                            "scene": scene,
                            "method": method,
                            "renderer": renderer,
                            "hardware": hardware[seed % len(hardware)],
                            "host": "nowhere",
                            "seed": seed,
                            "checkpoint": checkpoint,
                            "spp": round(100 * seconds),
                            "render_seconds": seconds,
                            "mse": rmse**2,
                            "rmse": rmse,
                            "relmse": 9 * rmse**2,
                            "smape": "",
                        }
                    )
    write_table(folder / "rows.csv", lines)


def write_experiment(folder: Path, scenes: list[str], seeds: int = 4) -> None:
    """All tables, images and runs."""
    write_rows(folder, scenes, seeds)
    write_curves(folder, scenes, seeds)
    write_findings(folder, scenes, seeds)
    methods = "".join(f"[[methods]]\nname = {json.dumps(m)}\n" for m in METHODS)
    record = '[record]\nversion = "0.1.0"\ncommand = "pathspace compare nothing -o nowhere"\n'
    (folder / "experiment.toml").write_text(f"seeds = {seeds}\n{methods}{record}", "utf-8")
    for index, scene in enumerate(scenes):
        write_images(folder, scene, seeds, index)


def write_curves(folder: Path, scenes: list[str], seeds: int) -> None:
    """Bands of a tenth; the last checkpoint of `bdpt` drowns in the noise of the reference."""
    write_table(
        folder / "curves.csv",
        [
            {
                "scene": scene,
                "method": method,
                "hardware": HARDWARE,
                "metric": metric,
                "checkpoint": checkpoint,
                "seeds": seeds,
                "seconds": seconds,
                "spp": 100 * seconds,
                "error": (error := factor * (level * seconds**-0.5) ** power),
                "low": 0.9 * error,
                "high": 1.1 * error,
                "below_reference_noise": str(method == "bdpt" and checkpoint == 7).lower(),
            }
            for scene in scenes
            for method, (_, level) in METHODS.items()
            for metric, factor, power in (("rmse", 1, 1), ("relmse", 9, 2), ("mse", 1, 2))
            for checkpoint, seconds in enumerate(SECONDS)
        ],
    )


def write_findings(folder: Path, scenes: list[str], seeds: int) -> None:
    """Efficiencies of the levels; `light` has a bias, of `mitsuba:ptracer` nothing is known."""
    summary, verdicts, agreement = [], [], []
    for scene in scenes:
        for method, (renderer, level) in METHODS.items():
            place = {"scene": scene, "hardware": HARDWARE}
            summary.append(
                {
                    **place,
                    "method": method,
                    "renderer": renderer,
                    "seeds": seeds,
                    "equal_time": 10.0,
                    "mse": level**2 / 10,
                    "rmse": level / 10**0.5,
                    "relmse": 9 * level**2 / 10,
                    "relative_efficiency": (0.4 / level) ** 2,
                    "base": "mitsuba:path",
                    "slope": -0.5,
                    "bias2": 1e-5 if method == "light" else 0.0,
                    "variance": level**2 / 10,
                }
            )
            verdict = {"light": "differ", "mitsuba:ptracer": "undecided (too few passes)"}
            agreement.append(
                {
                    "scene": scene,
                    "method": method,
                    "against": "reference",
                    "verdict": verdict.get(method, "agree"),
                    "image_difference": 0.0123456789 if method == "light" else 1e-5 / 3,
                    "image_error": 0.001,
                    "image_detectable": 0.005,
                }
            )
            for other, (_, reach) in METHODS.items():
                if method == other or level > reach:
                    continue
                ratio, none = (reach / level) ** 2, other == "mitsuba:ptracer"
                verdicts.append(
                    {
                        **place,
                        "metric": "rmse",
                        "method": method,
                        "other": other,
                        "seeds": seeds,
                        "target_error": "" if none else reach / 10**0.5,
                        "time_ratio": "" if none else ratio,
                        "low": "" if none else 0.8 * ratio,
                        "high": "" if none else 1.2 * ratio,
                        "verdict": "none" if none else "faster",
                        "crossing_seconds": "",
                    }
                )
    for name, lines in (("summary", summary), ("verdicts", verdicts), ("agreement", agreement)):
        write_table(folder / f"{name}.csv", lines)


def write_images(folder: Path, scene: str, seeds: int, key: int) -> None:
    """A gradient, and noise upon it whose variance is larger on the right."""
    random = np.random.default_rng(key)
    name = "".join(c if c.isalnum() or c in ".-_" else "_" for c in scene)
    y, x = np.mgrid[0:SIZE, 0 : SIZE + 8] / SIZE
    reference = np.stack([0.1 + x, 0.2 + y, 0.5 + 0 * x], axis=-1)
    error = np.full_like(reference, 0.001)
    names = [*"RGB", *(f"standard_error.{c}" for c in "RGB")]
    write_exr(folder / f"references/{name}.exr", np.concatenate([reference, error], -1), names)
    for method, (_, level) in METHODS.items():
        runs = [
            reference
            * (1 + 0.3 * level * (0.2 + x[..., None]) * random.normal(size=reference.shape))
            for _ in range(seeds)
        ]
        where = method.replace(":", "_")
        for seed, image in enumerate(runs):
            write_exr(folder / f"runs/{name}/{where}/{seed}/image.exr", image)
        write_exr(folder / f"images/{name}/{where}.exr", np.mean(runs, axis=0))


def write_exr(path: Path, pixels: np.ndarray, names: list[str] | None = None) -> None:
    """Write single-precision channels."""
    if mitsuba.variant() is None:
        mitsuba.set_variant("scalar_rgb")
    path.parent.mkdir(parents=True, exist_ok=True)
    pixel_format = mitsuba.Bitmap.PixelFormat.MultiChannel
    mitsuba.Bitmap(pixels.astype(np.float32), pixel_format, names or list("RGB")).write(str(path))
