"""``markermend recipe``: how a lab looks at takes, by name; and the option that uses one."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from markermend import detection
from markermend.errors import BadInput
from markermend.model import KINDS
from markermend_app.cli.common import json_text, kinds, positive
from markermend_app.cli.terminal import plain, put, say

if TYPE_CHECKING:
    from markermend.recipes import Recipe
    from markermend.recipes.shelf import Saved

STORE = "(default: MARKERMEND_STORE, else your data folder)"


def recipe_arguments(parser: argparse.ArgumentParser, store: str = "where recipes are") -> None:
    """Add --recipe, and --store to look it up in."""
    parser.add_argument(
        "--recipe", metavar="NAME", help="look as this recipe says: NAME, NAME@VERSION or FILE.json"
    )
    parser.add_argument("--store", metavar="PATH", help=f"{store} {STORE}")


def recipe_asked_for(options: argparse.Namespace) -> "Recipe | None":
    """Give the recipe of --recipe, or None."""
    if options.recipe is None:
        return None
    if options.detector != detection.DEFAULT:
        raise BadInput("A recipe names its detector; leave out --detector, or --recipe.")
    from markermend.recipes import read_recipe
    from markermend.recipes.shelf import fetch
    from markermend.review.store import Store

    if options.recipe.endswith(".json"):
        return read_recipe(options.recipe)
    with Store(options.store) as store:
        return fetch(store, options.recipe)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    what = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    save = what.add_parser("save", help="save a recipe as the next version of its name")
    save.add_argument("name", metavar="NAME")
    save.add_argument("--file", metavar="FILE.json", help="take all of it from this file")
    save.add_argument(
        "--detector",
        metavar="NAME",
        help=f"one of {', '.join(detection.DETECTORS.names())} (default: {detection.DEFAULT})",
    )
    save.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        help="a parameter of the detector; may be given again",
    )
    save.add_argument("--kinds", metavar="A,B", help="only these kinds, e.g. gap,peak")
    save.add_argument(
        "--sensitivity",
        metavar="KIND=X,…",
        help="1 as designed, 2 for half the threshold, e.g. peak=2,noise=0.5",
    )
    save.add_argument("--repair", metavar="POLICY", help="kinds, e.g. gap,peak, or a policy file")
    save.add_argument(
        "--most-mm", type=positive("mm"), metavar="MM", help="limit of the expected error"
    )
    save.add_argument("--note", metavar="TEXT", help="what it is for")
    listing = what.add_parser("list", help="list the recipes")
    show = what.add_parser("show", help="print a recipe, or write it to a file")
    show.add_argument("name", metavar="NAME", help="NAME or NAME@VERSION")
    show.add_argument("-o", "--out", metavar="FILE.json", type=Path, help="write it here")
    show.add_argument("--force", action="store_true", help="replace FILE.json if it is there")
    delete = what.add_parser("delete", help="delete all versions of a recipe")
    delete.add_argument("name", metavar="NAME")
    for one in (save, listing, show, delete):
        one.add_argument("--store", metavar="PATH", help=f"where recipes are {STORE}")
    listing.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> None:
    """Save, list, show or delete."""
    from markermend.recipes import shelf, write_recipe
    from markermend.review.store import Store, default_operator

    if options.what == "save":
        made = _made(options)
    with Store(options.store) as store:
        if options.what == "save":
            saved = shelf.save(store, options.name, made, default_operator())
            say(f"{plain(saved.name)}: version {saved.version}")
        elif options.what == "list":
            _list(shelf.on_the_shelf(store), as_json=options.json)
        elif options.what == "delete":
            gone = shelf.remove(store, options.name)
            say(f"{plain(options.name)}: {gone} version{'s' if gone > 1 else ''} deleted")
        elif options.out is not None:
            write_recipe(shelf.fetch(store, options.name), options.out, overwrite=options.force)
            say(f"{options.out}: the recipe {plain(options.name)}")
        else:
            put(json_text(shelf.fetch(store, options.name).to_json()))


def _list(found: "tuple[Saved, ...]", *, as_json: bool) -> None:
    if as_json:
        listed = [
            {
                "name": one.name,
                "version": one.version,
                "author": one.author,
                "at": one.at.isoformat(),
                "recipe": one.recipe.to_json(),
            }
            for one in found
        ]
        put(json_text({"version": 1, "recipes": listed}))
        return
    width = max((len(plain(one.name)) for one in found), default=4)
    for one in found:
        policy = one.recipe.policy
        repairs = "repairs nothing" if policy is None else f"repairs {', '.join(policy.kinds)}"
        say(
            f"{plain(one.name):{width}}  version {one.version}  {one.at.astimezone():%Y-%m-%d}  "
            f"{plain(one.author)}  {one.recipe.detector}, {repairs}  {plain(one.recipe.note)}"
        )
    say(f"{len(found)} recipes")


def _made(options: argparse.Namespace) -> "Recipe":
    from markermend.batch.policy import read_policy
    from markermend.recipes import Recipe, read_recipe

    single = ("detector", "set", "kinds", "sensitivity", "repair", "most_mm", "note")
    given = [name for name in single if getattr(options, name) is not None]
    if options.file is not None:
        if given:
            raise BadInput(f"All of the recipe is in --file; leave out --{_option(given[0])}.")
        return read_recipe(options.file)
    if options.most_mm is not None and options.repair is None:
        raise BadInput("--most-mm limits repairs; say with --repair what is repaired.")
    wanted = KINDS if options.kinds is None else kinds(options.kinds)
    return Recipe(
        detector=options.detector or detection.DEFAULT,
        parameters=_pairs("set", options.set or []),
        kinds=tuple(kind for kind in KINDS if kind in wanted),
        sensitivity=_factors(options.sensitivity or ""),
        policy=None if options.repair is None else read_policy(options.repair, options.most_mm),
        note=options.note or "",
    )


def _option(name: str) -> str:
    return name.replace("_", "-")


def _pairs(option: str, said: list[str]) -> dict[str, str]:
    pairs = [one.partition("=") for one in said]
    for name, equals, value in pairs:
        if not (name.strip() and equals and value.strip()):
            raise BadInput(f"--{option} takes NAME=VALUE; got {name + equals + value!r}.")
    return {name.strip(): value.strip() for name, _, value in pairs}


def _factors(said: str) -> Mapping[str, float]:
    pairs = _pairs("sensitivity", [one for one in said.split(",") if one.strip()])
    for kind in pairs:
        kinds(kind)
    try:
        return {kind: float(pairs[kind]) for kind in KINDS if kind in pairs}
    except ValueError:
        raise BadInput(f"--sensitivity takes KIND=X, as peak=2; got {said!r}.") from None
