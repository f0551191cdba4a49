"""Error over time, one value a checkpoint."""

import numpy as np
import pandas as pd

METRICS: dict[str, tuple[str, float | None]] = {
    "rmse": ("RMSE", -0.5),
    "relmse": ("relMSE", -1.0),
    "mse": ("MSE", -1.0),
    "smape": ("SMAPE", -0.5),
    "mape": ("MAPE", -0.5),
    "trimmed_mse": ("trimmed MSE", -1.0),
    "trimmed_relmse": ("trimmed relMSE", -1.0),
    "flip": ("FLIP", None),
}
"""Label of the axis; slope in logarithms of an unbiased estimator of finite variance."""

GROUPS = ["scene", "method", "hardware"]
COLUMNS = [*GROUPS, "metric", "checkpoint", "seeds", "seconds", "spp", "error", "low", "high"]


def curves_of_rows(rows: pd.DataFrame) -> pd.DataFrame:
    """Average rows over seeds, in logarithms; a stand-in for `curves.csv` with the same columns.

    The band is one geometric standard deviation of the error over the seeds.
    """
    parts = [curve_of(rows, metric) for metric in METRICS if metric in rows]
    found = (
        pd.concat([part for part in parts if not part.empty], ignore_index=True)
        if any(not part.empty for part in parts)
        else pd.DataFrame(columns=COLUMNS)
    )
    return found.assign(below_reference_noise=False)


def curve_of(rows: pd.DataFrame, metric: str) -> pd.DataFrame:
    """Average one metric; where nothing is positive, there is no line."""
    error = pd.to_numeric(rows[metric], errors="coerce")
    seconds = rows["render_seconds"]
    usable = np.isfinite(error) & (error > 0) & (seconds > 0)
    logs = rows.loc[usable, [*GROUPS, "checkpoint"]].assign(
        seconds=np.log(seconds[usable]),
        spp=np.log(rows.loc[usable, "spp"].clip(lower=1)),
        error=np.log(error[usable]),
    )
    groups = logs.groupby([*GROUPS, "checkpoint"], sort=False)
    mean = groups.mean()
    spread = groups["error"].std(ddof=1).fillna(0.0)
    found = np.exp(mean).assign(
        seeds=groups.size(),
        low=np.exp(mean["error"] - spread),
        high=np.exp(mean["error"] + spread),
        metric=metric,
    )
    return found.reset_index()[COLUMNS]
