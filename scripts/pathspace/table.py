"""Writes a table of an experiment for a paper or a page.

    python -m pathspace.table DIR
    python -m pathspace.table DIR --table verdicts --format latex -o verdicts.tex
    python -m pathspace.table DIR --columns method,rmse,time_to_target --digits 2

DIR is the folder of an experiment; the table is summary.csv, verdicts.csv, agreement.csv,
curves.csv or rows.csv, with the columns named, in this order. Numbers are rounded to significant
digits. LaTeX needs the package booktabs.
"""

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from .experiment import TABLES, Experiment, LoadError, load

COLUMNS = {
    "summary": "scene,method,seeds,rmse,relmse,time_to_target,relative_efficiency,slope",
    "verdicts": "scene,metric,method,other,target_error,time_ratio,low,high,verdict",
    "agreement": "scene,method,against,verdict,image_difference,image_error,image_detectable",
}
LATEX = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"} | {
    character: f"\\{character}" for character in "&%$#_{}"
}


class TableError(Exception):
    """A table or a column is not there."""


def table(
    experiment: Experiment,
    name: str = "summary",
    columns: Sequence[str] | None = None,
    style: str = "markdown",
    digits: int = 3,
) -> str:
    """Write a table as Markdown or LaTeX; scenes are set apart by a rule in LaTeX."""
    frame: pd.DataFrame = getattr(experiment, name)
    if frame.empty:
        raise TableError(f"{experiment.folder / name}.csv is missing or empty")
    wanted = columns or [c for c in COLUMNS.get(name, "").split(",") if c in frame] or list(frame)
    if unknown := [column for column in wanted if column not in frame]:
        raise TableError(f"{name}.csv has no column {unknown[0]}; it has: {', '.join(frame)}")
    chosen = frame[list(wanted)]
    numeric = [pd.api.types.is_numeric_dtype(chosen[c]) and chosen[c].dtype != bool for c in wanted]
    cells = [[cell(value, digits) for value in row] for row in chosen.itertuples(index=False)]
    return {"markdown": markdown, "latex": latex}[style](list(wanted), cells, numeric)


def cell(value: object, digits: int) -> str:
    """Write a value: floats with so many significant digits, nothing where there is nothing."""
    if isinstance(value, float):
        return "" if pd.isna(value) else f"{value:.{digits}g}"
    return str(value)


def markdown(header: list[str], cells: list[list[str]], numeric: list[bool]) -> str:
    """Write a Markdown table, padded so that it can be read as it stands."""
    escaped = [[text.replace("|", "\\|") for text in row] for row in [header, *cells]]
    widths = [max(3, *(len(row[i]) for row in escaped)) for i in range(len(header))]
    lines = [
        "| "
        + " | ".join(
            t.rjust(w) if n else t.ljust(w) for t, w, n in zip(row, widths, numeric, strict=True)
        )
        + " |"
        for row in escaped
    ]
    rule = [
        "-" * (w + 1) + ":" if n else "-" * (w + 2) for w, n in zip(widths, numeric, strict=True)
    ]
    return "\n".join([lines[0], "|" + "|".join(rule) + "|", *lines[1:]]) + "\n"


def latex(header: list[str], cells: list[list[str]], numeric: list[bool]) -> str:
    """Write a LaTeX tabular."""
    lines = ["\\begin{tabular}{" + "".join("r" if n else "l" for n in numeric) + "}", "\\toprule"]
    lines += [row_of(header, [False] * len(header)), "\\midrule"]
    for index, row in enumerate(cells):
        if header[0] == "scene" and index > 0 and row[0] != cells[index - 1][0]:
            lines.append("\\addlinespace")
        lines.append(row_of(row, numeric))
    return "\n".join([*lines, "\\bottomrule", "\\end{tabular}"]) + "\n"


def row_of(texts: list[str], numeric: list[bool]) -> str:
    """Write a row; numbers are set as formulas, with powers of ten."""
    return (
        " & ".join(formula(t) if n else escape(t) for t, n in zip(texts, numeric, strict=True))
        + r" \\"
    )


def formula(text: str) -> str:
    """Write a number as a formula."""
    text = re.sub(r"e([+-])0*(\d+)$", lambda m: rf" \cdot 10^{{{m[1].strip('+')}{m[2]}}}", text)
    text = text.replace("inf", r"\infty")
    return f"${text}$" if text else ""


def escape(text: str) -> str:
    """Write text that LaTeX reads as it stands."""
    return "".join(LATEX.get(character, character) for character in text)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m pathspace.table",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of an experiment")
    parser.add_argument("--table", choices=TABLES, default="summary")
    parser.add_argument("--columns", metavar="A,B,…", help="default: those that a paper shows")
    parser.add_argument("--format", choices=["markdown", "latex"], default="markdown")
    parser.add_argument("--digits", type=int, default=3, help="significant digits; default: 3")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="default: standard output"
    )
    options = parser.parse_args(arguments)
    columns = options.columns.split(",") if options.columns else None
    try:
        text = table(load(options.folder), options.table, columns, options.format, options.digits)
        if options.output:
            options.output.write_text(text, encoding="utf-8")
    except (LoadError, TableError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print(options.output or text, end="\n" if options.output else "")
    return 0


if __name__ == "__main__":
    sys.exit(main())
