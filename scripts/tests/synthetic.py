"""Rows of a comparison that never took place."""

import csv
from pathlib import Path

import numpy as np

HEADER = (
    "scene,method,renderer,seed,threads,checkpoint,spp,render_seconds,cpu_seconds,setup_seconds,"
    "rays,mse,rmse,relmse,smape,mean_ratio,invalid"
)
METHODS = {
    "path": ("pathspace 0.1.0", 0.3),
    "light": ("pathspace 0.1.0", 0.5),
    "bdpt": ("pathspace 0.1.0", 0.2),
    "mitsuba:path": ("mitsuba 3.9.1 llvm_ad_rgb", 0.4),
    "mitsuba:ptracer": ("mitsuba 3.9.1 llvm_ad_rgb", 0.7),
}


def write_rows(folder: Path, scenes: list[str], seeds: int = 5) -> None:
    """Errors that fall as the inverse square root of time, with some noise."""
    random = np.random.default_rng(7)
    with (folder / "rows.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, HEADER.split(","), restval="")
        writer.writeheader()
        for scene in scenes:
            for method, (renderer, level) in METHODS.items():
                for seed in range(seeds):
                    for checkpoint, target in enumerate(np.geomspace(0.2, 10, 8)):
                        seconds = target * (1 + 0.1 * random.random())
                        rmse = level * seconds**-0.5 * np.exp(0.1 * random.normal())
                        writer.writerow(
                            {
                                "scene": scene,
                                "method": method,
                                "renderer": renderer,
                                "seed": seed,
                                "checkpoint": checkpoint,
                                "render_seconds": seconds,
                                "mse": rmse**2,
                                "rmse": rmse,
                                "relmse": 9 * rmse**2,
                            }
                        )
