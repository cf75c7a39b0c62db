"""``markermend evaluate EXPERIMENT``: the published experiments, and benchmarks, as tables."""

import argparse
import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from markermend_app.cli.common import read, take_argument
from markermend_app.cli.experiments import recovery
from markermend_app.cli.experiments.shared import (
    bar,
    json_argument,
    numbers,
    print_table,
    whole_numbers,
    words,
    work_arguments,
    write_json,
)
from markermend_app.cli.picture import picture_argument, refuse_picture, write_picture
from markermend_app.cli.terminal import say


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the experiments."""
    experiments = parser.add_subparsers(dest="experiment", metavar="EXPERIMENT", required=True)

    e1 = experiments.add_parser(
        "e1", help="how well detectors find and classify artefacts that were put into a take"
    )
    take_argument(e1)
    _detectors(e1)
    e1.add_argument("--amplitude", type=numbers, default=(5.0, 10.0), metavar="MM,MM")
    e1.add_argument("--share", type=numbers, default=(0.05, 0.1, 0.2), metavar="S,S")
    _simulations(e1, 100)
    picture_argument(e1)

    e2 = experiments.add_parser(
        "e2", help="simulated operators clean a take; what detectors and an expert then find"
    )
    take_argument(e2)
    _detectors(e2)
    e2.add_argument("--amplitude", type=float, default=10.0, metavar="MM")
    e2.add_argument("--share", type=float, default=0.02, metavar="S")
    _simulations(e2, 10)
    picture_argument(e2)

    e3 = experiments.add_parser(
        "e3", help="how much of an artefact repairs remove, with perfect and detected spans"
    )
    take_argument(e3)
    _detectors(e3)
    e3.add_argument("--methods", type=words, default=(), metavar="A,B", help="default: by kind too")
    e3.add_argument("--amplitude", type=float, default=10.0, metavar="MM")
    e3.add_argument("--share", type=numbers, default=(0.05, 0.1, 0.2), metavar="S,S")
    _simulations(e3, 20)
    picture_argument(e3)

    predictors = experiments.add_parser(
        "predictors", help="how well markers are predicted from their neighbours, and by what"
    )
    take_argument(predictors)
    predictors.add_argument("--tables", type=words, default=(), metavar="A,B")
    predictors.add_argument("--markers", type=words, default=(), metavar="A,B")
    predictors.add_argument("--seed", type=int, default=0)
    json_argument(predictors)
    picture_argument(predictors)

    mesh = experiments.add_parser(
        "mesh", help="the functional body mesh: clusters of markers, their parents and siblings"
    )
    take_argument(mesh)
    json_argument(mesh)
    picture_argument(mesh)

    recovery.arguments(experiments)

    masks = experiments.add_parser("masks", help="fill the gaps of a benchmark by any methods")
    masks.add_argument("masks", type=Path, metavar="FILE", help="masks, beside datasets.json")
    masks.add_argument("--methods", type=words, default=("auto",), metavar="A,B")
    masks.add_argument("--datasets", type=words, default=(), metavar="A,B")
    masks.add_argument("--lengths", type=whole_numbers, default=(), metavar="N,N")
    masks.add_argument("--seeds", type=whole_numbers, default=(), metavar="N,N")
    masks.add_argument("--peers", type=Path, metavar="CSV", help="errors of other programs")
    masks.add_argument("--jobs", type=int, default=1, metavar="J")
    json_argument(masks)
    picture_argument(masks)


def _detectors(parser: argparse.ArgumentParser) -> None:
    from markermend.detection import DEFAULT, DETECTORS

    parser.add_argument(
        "--detector",
        type=words,
        default=(DEFAULT,),
        metavar="A,B",
        help=f"some of {', '.join(DETECTORS.names())} (default: {DEFAULT})",
    )


def _simulations(parser: argparse.ArgumentParser, default: int) -> None:
    parser.add_argument("--simulations", type=int, default=default, metavar="N")
    work_arguments(parser)


def run(options: argparse.Namespace) -> None:
    """Run one experiment and print its tables."""
    refuse_picture(vars(options).get("picture"))
    RUNS[options.experiment](options)


def _e1(options: argparse.Namespace) -> None:
    from markermend.evaluate import e1

    result = e1(
        read(options.take, options),
        detectors=options.detector,
        amplitudes=options.amplitude,
        shares=options.share,
        simulations=options.simulations,
        jobs=options.jobs,
        seed=options.seed,
        progress=bar("Simulating"),
    )
    print_table(*result.table())
    write_json(options.json, result.to_json())
    if options.picture:
        from markermend_app.plots.experiments import classification

        write_picture(options.picture, classification(result, options.take.name))


def _e2(options: argparse.Namespace) -> None:
    from markermend.evaluate import e2

    results = []
    for detector in options.detector:
        result = e2(
            read(options.take, options),
            detector=detector,
            amplitude_mm=options.amplitude,
            share=options.share,
            simulations=options.simulations,
            jobs=options.jobs,
            seed=options.seed,
            progress=bar("Simulating"),
        )
        say(f"detector {detector}, mean of {options.simulations}")
        print_table(*result.table())
        results.append(result)
    records = [result.to_json() for result in results]
    write_json(options.json, {"version": 1, "experiment": "e2", "detectors": records})
    if options.picture:
        from markermend_app.plots.experiments import operators

        write_picture(options.picture, operators(results, options.take.name))


def _e3(options: argparse.Namespace) -> None:
    from markermend.evaluate.reconstruction import METHODS, e3

    methods = tuple("" if name == "default" else name for name in options.methods) or METHODS
    result = e3(
        read(options.take, options),
        methods=methods,
        shares=options.share,
        amplitude_mm=options.amplitude,
        detector=options.detector[0],
        simulations=options.simulations,
        jobs=options.jobs,
        seed=options.seed,
        progress=bar("Simulating"),
    )
    print_table(*result.table())
    write_json(options.json, result.to_json())
    if options.picture:
        from markermend_app.plots.experiments import reconstruction

        write_picture(options.picture, reconstruction(result, options.take.name))


def _predictors(options: argparse.Namespace) -> None:
    from markermend.evaluate import predictors
    from markermend.evaluate.prediction import TABLES

    result = predictors(
        read(options.take, options),
        tables=options.tables or TABLES,
        markers=options.markers,
        seed=options.seed,
        progress=bar("Predicting"),
    )
    for title, columns, rows in result.tables():
        say(title)
        print_table(columns, rows)
    write_json(options.json, result.to_json())
    if options.picture:
        from markermend_app.plots import prediction

        write_picture(options.picture, prediction.predictors(result, options.take.name))


def _mesh(options: argparse.Namespace) -> None:
    from markermend.body import infer
    from markermend_app.cli.mesh import mesh_record, mesh_table

    take = read(options.take, options)
    body = infer(take)
    print_table(*mesh_table(body))
    write_json(options.json, mesh_record(take, body))
    if options.picture:
        from markermend_app.plots.mesh import body_mesh

        write_picture(options.picture, body_mesh(take, body, options.take.name))


def _masks(options: argparse.Namespace) -> None:
    from markermend.evaluate.masks import evaluate_masks, read_peers, table

    errors = evaluate_masks(
        options.masks,
        options.methods,
        datasets=options.datasets,
        lengths=options.lengths,
        seeds=options.seeds,
        workers=options.jobs,
        progress=bar("Filling"),
    )
    rows = table(errors, read_peers(options.peers) if options.peers else None)
    columns = (
        "cell", "method", "gaps", "unfilled", "mean mm", "sd", "median", "best other", "its mean",
        "ratio", "ms a gap",
    )  # fmt: skip
    shown = [
        (
            row.cell,
            row.method,
            str(row.n),
            str(row.left),
            *(f"{value:.2f}" for value in (row.mean_mm, row.sd_mm, row.median_mm)),
            row.best or "-",
            f"{row.best_mm:.2f}",
            f"{row.ratio:.3f}",
            f"{row.ms:.0f}",
        )
        for row in rows
    ]
    print_table(columns, shown)
    write_json(
        options.json,
        {
            "version": 1,
            "experiment": "masks",
            "rows": [_finite(asdict(row)) for row in rows],
        },
    )
    if options.picture:
        from markermend_app.plots import masks

        seeds = sorted({error.seed for error in errors})
        write_picture(options.picture, masks.masks(rows, seeds))


RUNS: dict[str, Callable[[argparse.Namespace], None]] = {
    "e1": _e1,
    "e2": _e2,
    "e3": _e3,
    "predictors": _predictors,
    "li": recovery.run_li,
    "kamali": recovery.run_kamali,
    "mesh": _mesh,
    "masks": _masks,
}


def _finite(record: dict[str, Any]) -> dict[str, Any]:
    """Put null where there is no number."""
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in record.items()
    }
