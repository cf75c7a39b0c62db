"""Recipes in the store, by name: every change is a new version, and old ones stay."""

import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Row, delete, func, select

from markermend.errors import BadInput, StoreError, UnknownName
from markermend.recipes.recipe import Recipe, read_recipe, recipe_from_json
from markermend.review.schema import recipes
from markermend.review.store import Store

_NAME = re.compile(r"[\w][\w .+-]{0,63}")
_TRIES = 5


@dataclass(frozen=True)
class Saved:
    """A version of a recipe, as it was saved."""

    name: str
    version: int
    recipe: Recipe
    author: str
    at: datetime


def save(store: Store, name: str, recipe: Recipe, author: str) -> Saved:
    """Save a recipe as the next version of that name; one that is as the last is not saved again.

    Raises
    ------
    BadInput
        If the name is none that could be typed.
    """
    if not _NAME.fullmatch(name) or name.endswith(".json"):
        raise BadInput(
            f"A recipe's name has 1 to 64 letters, digits and spaces, and is no file; got {name!r}."
        )
    for _ in range(_TRIES):
        last = versions(store, name)[:1]
        if last and last[0].recipe == recipe:
            return last[0]
        number = last[0].version + 1 if last else 1
        try:
            store.add_line(
                recipes,
                name=name,
                version=number,
                content=recipe.to_json(),
                author=author,
                at=store.now(),
            )
        except StoreError:
            if find(store, name, number) is None:
                raise
            continue  # somebody else saved that version in between
        return versions(store, name)[0]
    raise StoreError(f"Others keep saving the recipe {name!r}; try again.")


def find(store: Store, name: str, version: int | None = None) -> Saved | None:
    """Give a recipe, by default its latest version, or None."""
    found = (one for one in versions(store, name) if version in (None, one.version))
    return next(found, None)


def versions(store: Store, name: str) -> tuple[Saved, ...]:
    """Give all versions of a recipe, the latest first."""
    query = select(recipes).where(recipes.c.name == name).order_by(recipes.c.version.desc())
    return tuple(_saved(row) for row in store.rows(query))


def on_the_shelf(store: Store) -> tuple[Saved, ...]:
    """Give the latest version of every recipe, by name."""
    last = select(recipes.c.name, func.max(recipes.c.version).label("last")).group_by(
        recipes.c.name
    )
    newest = last.subquery()
    query = (
        select(recipes)
        .join(newest, (recipes.c.name == newest.c.name) & (recipes.c.version == newest.c.last))
        .order_by(recipes.c.name)
    )
    return tuple(_saved(row) for row in store.rows(query))


def remove(store: Store, name: str) -> int:
    """Remove all versions of a recipe, and say how many there were.

    Raises
    ------
    UnknownName
        If there is none of that name.
    """
    with store.transaction() as connection:
        gone = connection.execute(delete(recipes).where(recipes.c.name == name)).rowcount
    if not gone:
        raise _unknown(store, name)
    return int(gone)


def fetch(store: Store, said: str) -> Recipe:
    """Understand what was said on a command line: a file, a name, or a name and a version.

    Parameters
    ----------
    store
        Where names are looked up.
    said
        ``"gait.json"``, ``"gait"``, or ``"gait@2"``.

    Raises
    ------
    UnknownName
        If there is no such recipe.
    BadInput
        If the file is no recipe.
    """
    if said.endswith(".json"):
        return read_recipe(Path(said))
    name, _, number = said.partition("@")
    if number and not number.isdecimal():
        raise BadInput(f"A version is a whole number, as in {name}@2; got {said!r}.")
    found = find(store, name, int(number) if number else None)
    if found is None:
        raise _unknown(store, said)
    return found.recipe


def _unknown(store: Store, said: str) -> UnknownName:
    return UnknownName.among("recipe", said, [one.name for one in on_the_shelf(store)])


def _saved(row: Row[Any]) -> Saved:
    recipe = recipe_from_json(row.content, f"The recipe {row.name}")
    return Saved(row.name, row.version, recipe, row.author, row.at)
