"""Writes the colour tables of the reader of Mitsuba's scenes, from the data of the Mitsuba wheel.

    .venv/bin/python scripts/pathspace/mitsuba_tables.py > src/scene/mitsuba/read/tables.rs

The observer and the illuminant are those of the CIE (1931, 2 degrees; D65), every 5 nm. The metals
are those of refractiveindex.info and of Palik's handbook (the names that end in `_palik`) as
Mitsuba has collected them, as linear RGB by Mitsuba's own conversion of `eta` and `k`.
"""

from __future__ import annotations

from pathlib import Path

import mitsuba as mi

FIRST, LAST, STEP = 360, 830, 5


def metals() -> dict[str, tuple[list[float], list[float]]]:
    """`eta` and `k` of every metal that Mitsuba knows by name."""
    folder = Path(mi.__file__).parent / "data" / "ior"
    names = sorted(file.name.removesuffix(".eta.spd") for file in folder.glob("*.eta.spd"))
    files = {name: (folder / f"{name}.eta.spd", folder / f"{name}.k.spd") for name in names}
    return {name: (rgb(eta), rgb(k)) for name, (eta, k) in files.items()}


def rgb(file: Path) -> list[float]:
    """A spectrum as linear RGB, neither bounded nor under an illuminant."""
    wavelengths, values = mi.spectrum_from_file(str(file))
    colour = mi.spectrum_list_to_srgb(wavelengths, values, bounded=False, d65=False)
    return [float(x) for x in colour]


def row(numbers: list[float]) -> str:
    """The numbers as Rust has them: seven digits are what single precision holds."""
    return "[" + ", ".join(repr(float(f"{x:.8g}")) for x in numbers) + "]"


def main() -> None:
    """Prints the module."""
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    wavelengths = range(FIRST, LAST + 1, STEP)
    observer = [[float(x) for x in mi.cie1931_xyz(w)] for w in wavelengths]
    daylight = [float(mi.cie_d65(w)) for w in wavelengths]
    print("//! Made by `scripts/pathspace/mitsuba_tables.py`, which names the sources.\n")
    print("/// The CIE's standard observer of 1931 (2 degrees): x̄, ȳ, z̄")
    print(f"/// from {FIRST} to {LAST} nm every {STEP} nm.")
    print("#[rustfmt::skip]")
    print(f"pub(super) const OBSERVER: [[f64; 3]; {len(observer)}] = [")
    for values in observer:
        print(f"    {row(values)},")
    print("];\n")
    print("/// The CIE's illuminant D65 at the same wavelengths, scaled as Mitsuba does.")
    print("#[rustfmt::skip]")
    print(f"pub(super) const D65: [f64; {len(daylight)}] = [")
    for value in daylight:
        print(f"    {float(f'{value:.8g}')!r},")
    print("];\n")
    table = metals()
    print("/// Name, η and k of the metals, linear RGB.")
    print("#[rustfmt::skip]")
    print(f"pub(super) const METALS: [(&str, [f64; 3], [f64; 3]); {len(table)}] = [")
    for name, (eta, k) in table.items():
        print(f'    ("{name}", {row(eta)}, {row(k)}),')
    print("];")


if __name__ == "__main__":
    main()
