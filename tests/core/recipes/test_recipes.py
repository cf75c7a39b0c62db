"""Recipes: what is saved comes back, every change is a version, and a batch looks as it says."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from markermend import detection
from markermend.batch.policy import Policy, Rule
from markermend.batch.settings import Settings
from markermend.errors import BadInput, CannotWrite, MarkerMendError, UnknownName
from markermend.model import KINDS, Take
from markermend.recipes import Recipe, read_recipe, recipe_from_json, write_recipe
from markermend.recipes.shelf import fetch, find, on_the_shelf, remove, save, versions
from markermend.review.store import Store

factors = st.dictionaries(st.sampled_from(KINDS), st.floats(0.1, 10))
rules = st.builds(
    Rule,
    st.sampled_from(["", "auto", "pchip"]),
    most_mm=st.none() | st.floats(0, 100),
    most_s=st.none() | st.floats(0, 10),
)
policies = st.builds(Policy, st.dictionaries(st.sampled_from(KINDS), rules, min_size=1))
some_recipes = st.builds(
    Recipe,
    detector=st.sampled_from(detection.DETECTORS.names()),
    kinds=st.sets(st.sampled_from(KINDS), min_size=1).map(
        lambda some: tuple(kind for kind in KINDS if kind in some)
    ),
    sensitivity=factors,
    policy=st.none() | policies,
    note=st.text(max_size=20),
)
GAIT = Recipe(
    "published",
    kinds=("gap", "peak"),
    sensitivity={"peak": 2.0},
    policy=Policy({"gap": Rule("auto", most_mm=5.0)}),
    note="level walking",
)


@pytest.fixture
def store(tmp_path: Path):  # type: ignore[no-untyped-def]
    with Store(tmp_path / "reviews.sqlite") as opened:
        yield opened


@pytest.fixture(scope="module")
def take() -> Take:
    """A marker with a gap and a small spike."""
    rng = np.random.default_rng(5)
    t = np.arange(400) / 100
    path = np.stack([1000 * t, 50 * np.sin(4 * t), 900 + 30 * np.cos(4 * t)], axis=1)
    positions = path[:, None] + np.array([[0, 0, 0], [0, 80, 0], [60, 0, 40.0]])
    positions += rng.normal(0, 0.1, positions.shape)
    positions[100:110, 0] = np.nan
    positions[250, 1, 2] += 8
    return Take(positions, 100.0, ("A", "B", "C"))


@settings(deadline=None)
@given(some_recipes)
def test_what_is_written_reads_as_it_was(recipe: Recipe) -> None:
    record = json.loads(json.dumps(recipe.to_json()))
    assert recipe_from_json(record, "It") == recipe


def test_it_looks_as_closely_as_it_says(take: Take) -> None:
    assert Recipe().detect(take) == detection.detect(take)
    assert GAIT.detect(take) == detection.detect(
        take, "published", kinds=("gap", "peak"), sensitivity={"peak": 2.0}
    )
    blunt, keen = (
        Recipe("published", kinds=("peak",), sensitivity={"peak": x}).detect(take)
        for x in (0.1, 10)
    )
    assert {f.id for f in blunt} < {f.id for f in keen}


def test_a_batch_looks_as_it_says_and_repairs_only_when_asked() -> None:
    seen = GAIT.settings(units="mm")
    assert (seen.detector, seen.kinds, seen.sensitivity) == (
        "published",
        ("gap", "peak"),
        {"peak": 2.0},
    )
    assert (seen.units, seen.policy) == ("mm", None)
    assert GAIT.settings(repair=True).policy == GAIT.policy
    assert Recipe().settings().key == Settings().key
    assert len({one.settings().key for one in (Recipe(), GAIT, Recipe("published"))}) == 3
    with pytest.raises(BadInput, match="repairs nothing"):
        Recipe().settings(repair=True)


def test_every_change_is_a_version_and_old_ones_stay(store: Store) -> None:
    first = save(store, "gait", GAIT, "anna")
    assert (first.version, first.author, first.recipe) == (1, "anna", GAIT)
    assert save(store, "gait", GAIT, "bo") == first
    second = save(store, "gait", Recipe("published"), "bo")
    back = save(store, "gait", GAIT, "anna")
    assert [one.version for one in versions(store, "gait")] == [3, 2, 1]
    assert find(store, "gait") == back
    assert find(store, "gait", 2) == second
    assert find(store, "run") is None


def test_the_shelf_holds_the_latest_of_each(store: Store) -> None:
    for name, recipe in (("gait", GAIT), ("run", Recipe()), ("gait", Recipe("published"))):
        save(store, name, recipe, "anna")
    assert [(one.name, one.version) for one in on_the_shelf(store)] == [("gait", 2), ("run", 1)]
    assert fetch(store, "gait") == Recipe("published")
    assert fetch(store, "gait@1") == GAIT
    assert remove(store, "gait") == 2
    for call in (lambda: remove(store, "gait"), lambda: fetch(store, "gait")):
        with pytest.raises(UnknownName, match="There is no recipe 'gait'; known are run"):
            call()
    with pytest.raises(UnknownName, match="'run@7'"):
        fetch(store, "run@7")
    with pytest.raises(BadInput, match="A version is a whole number"):
        fetch(store, "run@new")


@pytest.mark.parametrize("name", ["", " ", "x" * 65, "a/b", "gait.json", "a@2", "a\nb"])
def test_a_name_can_be_typed(store: Store, name: str) -> None:
    with pytest.raises(BadInput, match="A recipe's name has"):
        save(store, name, GAIT, "anna")


def test_a_file_carries_it_to_another_lab(store: Store, tmp_path: Path) -> None:
    path = tmp_path / "gait.json"
    write_recipe(GAIT, path)
    assert read_recipe(path) == fetch(store, str(path)) == GAIT
    with pytest.raises(CannotWrite):
        write_recipe(GAIT, path)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"schema": "other"}, "schema"),
        ({"version": 2}, "newer version"),
        ({"detector": "magic"}, "magic"),
        ({"parameters": {"magic": 1}}, "magic"),
        ({"parameters": []}, "must be an object"),
        ({"kinds": ["blip"]}, "blip"),
        ({"kinds": []}, "looks for some of"),
        ({"sensitivity": {"blip": 1}}, "blip"),
        ({"sensitivity": {"peak": 11}}, "0.1 to 10"),
        ({"sensitivity": {"peak": float("nan")}}, "0.1 to 10"),
        ({"sensitivity": 2}, "number by kind"),
        ({"repair": {"gap": {"method": "magic"}}}, "magic"),
        ({"repair": {}}, "rule by kind"),
        ({"magic": 1}, "magic"),
    ],
)
def test_what_is_no_recipe_is_refused(tmp_path: Path, change: dict[str, object], said: str) -> None:
    path = tmp_path / "recipe.json"
    path.write_text(json.dumps({**GAIT.to_json(), **change}))
    with pytest.raises(BadInput, match=said) as caught:
        read_recipe(path)
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize("text", ["", "{", "[" * 5000, "null", "[]"])
def test_what_is_no_json_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "recipe.json"
    path.write_text(text)
    with pytest.raises(MarkerMendError, match=r"recipe"):
        read_recipe(path)
    with pytest.raises(BadInput, match="cannot be read"):
        read_recipe(tmp_path / "absent.json")
