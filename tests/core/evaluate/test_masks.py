"""The protocols of hidden gaps: every gap is accounted for, whoever could fill it."""

import json

import numpy as np
import pytest

from markermend.errors import BadInput, UnknownName
from markermend.evaluate.masks import against, evaluate_masks, read_peers, table


@pytest.fixture
def protocol(tmp_path):
    time = np.arange(200.0)
    body = np.stack([np.column_stack([time * (m + 1), time, time * 0]) for m in range(3)], axis=1)
    body[:, 0] += 30 * np.sin(time / 20)[:, None]
    (tmp_path / "data").mkdir()
    np.save(tmp_path / "data" / "walk.npy", body)
    described = {"walk": {"rate": 100.0, "labels": ["A", "B", "C"]}}
    (tmp_path / "datasets.json").write_text(json.dumps(described))
    mask = {"protocol": "T", "dataset": "walk", "length": 10, "window": [0, 200]}
    gaps = [[(0, 50, 60), (2, 80, 90)], [(1, 120, 130), (0, 190, 200)]]
    masks = [
        mask
        | {
            "id": f"T_{seed}",
            "seed": seed,
            "markers": [0, 1, 2],
            "gaps": [dict(zip(("marker", "start", "stop"), g, strict=True)) for g in gaps[seed]],
        }
        for seed in (0, 1)
    ]
    (tmp_path / "masks.json").write_text(json.dumps(masks))
    programs = ("WPCA_R2", "GLR", "LPR", "LGRNN", "LI", "PMA", "gapfill_rbt4", "cubic", "pchip")
    lines = ["mask_id,gap,method,engine,err_mm"]
    lines += [f"T_0,{g},{p},port,{i + 1}.0" for i, p in enumerate(programs) for g in (0, 1)]
    lines += ["T_0,0,GLR,octave,0.5", "T_0,1,GLR_w7,port,0.25", "T_1,0,cubic,python,"]
    (tmp_path / "peers.csv").write_text("\n".join(lines) + "\n")
    return tmp_path


def test_every_gap_is_scored_and_refusals_are_counted(protocol):
    errors = evaluate_masks(protocol / "masks.json", ["linear", "pchip"])
    assert len(errors) == 8
    straight = [e for e in errors if e.method == "linear"]
    assert [np.isfinite(e.mean_mm) for e in straight] == [True, True, True, False]
    assert straight[1].mean_mm == pytest.approx(0, abs=1e-9)
    t = np.arange(50.0, 60)
    curve = 30 * np.sin(np.arange(49.0, 61) / 20)
    chord = np.interp(t, [49, 60], curve[[0, -1]])
    assert straight[0].mean_mm == pytest.approx(np.sqrt(3) * np.abs(chord - curve[1:-1]).mean())
    assert "not seen on both sides" in straight[3].refusal
    row = table(straight)[0]
    assert (row.n, row.left, row.best) == (4, 1, "")


def test_the_best_other_program_is_taken_over_common_gaps(protocol):
    peers = read_peers(protocol / "peers.csv")
    assert peers["GLR"] == {("T_0", 0): 0.5, ("T_0", 1): 0.25}
    assert np.isnan(peers["cubic"]["T_1", 0])
    errors = evaluate_masks(protocol / "masks.json", ["pchip"])
    row = table(errors, peers)[0]
    assert (row.best, row.best_mm) == ("GLR", 0.375)
    ours = np.mean([e.mean_mm for e in errors if e.mask == "T_0"])
    assert row.ratio == pytest.approx(ours / 0.375)
    assert against(errors, peers["LPR"]) == (2, pytest.approx(ours), 3.0)


def test_processes_do_not_change_the_numbers(protocol):
    def numbers(**options):
        errors = evaluate_masks(protocol / "masks.json", ["pchip"], **options)
        return [(e.mask, e.gap, e.mean_mm) for e in errors if e.mask == "T_0"]

    assert numbers(workers=2) == numbers() == numbers(seeds=[0])


def test_says_what_it_cannot_use(protocol, tmp_path):
    with pytest.raises(BadInput, match=r"is no file of masks .* name such a file\."):
        evaluate_masks(tmp_path / "nothing.json", ["pchip"])
    with pytest.raises(BadInput, match="no mask of the kind wanted"):
        evaluate_masks(protocol / "masks.json", ["pchip"], lengths=[77])
    with pytest.raises(UnknownName):
        evaluate_masks(protocol / "masks.json", ["magic"])
