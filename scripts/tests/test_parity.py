import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from pathspace.files import write_array
from pathspace.parity.catalogue import all_cases, chosen
from pathspace.parity.page import main as make_page
from pathspace.parity.run import main as run

HEADER = (
    "schema,feature,comparison,verdict,difference,interval,detectable,block_detectable,power,"
    "blocks_differing,largest_error,bound,values,details\n"
)


def test_cases_are_xml_with_names_of_their_own() -> None:
    cases = all_cases(full=False)
    assert len({case.name for case in cases}) == len(cases) > 100
    for case in cases:
        scene = ElementTree.fromstring(case.text)
        assert scene.find(".//sensor") is not None and scene.find(".//emitter") is not None
        assert "%" not in case.text, case.name


def test_features_are_named_whole_by_their_beginning_or_by_a_part() -> None:
    names = [case.name for case in chosen(["bsdf/diffuse", "checker"], full=False)]
    assert names == ["bsdf/diffuse", "texture/checkerboard"]
    assert len(chosen(["emitter/area"], full=False)) == 1
    assert len(chosen(["emitter/area-"], full=False)) > 3
    assert all(case.name.startswith("filter/") for case in chosen(["filter/"], full=False))
    with pytest.raises(LookupError, match="nonsense"):
        chosen(["nonsense"], full=False)
    assert run(["--out", "unused", "--list", "nonsense"]) == 2


def test_mitsuba_gives_images_and_values(tmp_path: Path) -> None:
    assert run(["--out", str(tmp_path), "--passes", "2", "bsdf/diffuse-ball"]) == 0
    folder = tmp_path / "bsdf/diffuse-ball"
    passes = np.load(folder / "mitsuba-path.npy")
    assert passes.shape == (2, 32, 32, 3) and not np.array_equal(passes[0], passes[1])
    assert (folder / "points.json").is_file() and (tmp_path / "cases.json").is_file()


def test_page_shows_every_verdict_and_escapes_what_it_shows(tmp_path: Path) -> None:
    rows = [
        "1,bsdf/a,path/path,agree,0.001,0.002,0.01,0.02,0.9,0,,,,fine\n",
        "1,bsdf/a,eval,differ,,,,,,,0.01,1e-6,720,<b>off</b>\n",
        "1,shape/b,scene,missing,,,,,,,,,,not there\n",
    ]
    (tmp_path / "parity.csv").write_text(HEADER + "".join(rows))
    (tmp_path / "bsdf/a").mkdir(parents=True)
    write_array(tmp_path / "bsdf/a/mitsuba-path.npy", np.zeros((2, 4, 4, 3), np.float32))
    assert make_page([str(tmp_path)]) == 0
    text = (tmp_path / "parity.html").read_text()
    assert "&lt;b&gt;off" in text and "<b>off" not in text
    assert 'id="shape/b"' in text and "1 missing" in text and "720" in text
