"""Recipes: how a lab looks at takes and what it repairs, by name, shared and versioned."""
