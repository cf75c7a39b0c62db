"""``markermend demo``: the demonstration take in the application."""

import argparse

from markermend.assets import demonstration
from markermend_app.cli import review


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    review.serving(parser)
    parser.set_defaults(units=None, rate=None, ignore_residuals=False)


def run(options: argparse.Namespace) -> None:
    """Serve the demonstration take."""
    review.refuse_without_the_extra()
    review.serve(options, (demonstration(),))
