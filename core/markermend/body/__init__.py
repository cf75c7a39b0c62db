"""The functional body mesh: which markers move together, and how their groups hang together."""

from markermend.body.mesh import Body, infer

__all__ = ["Body", "infer"]
