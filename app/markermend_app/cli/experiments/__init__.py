"""Experiments of ``markermend evaluate`` with a module of their own, and what all share."""
