"""Recipes: how a lab looks at takes and what it repairs, by name, shared and versioned."""

from markermend.recipes.recipe import Recipe, read_recipe, recipe_from_json, write_recipe

__all__ = ["Recipe", "read_recipe", "recipe_from_json", "write_recipe"]
