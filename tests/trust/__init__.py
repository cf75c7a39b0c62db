"""Whether MarkerMend can be trusted with somebody's recordings, as a table of figures.

``python -m tests.trust`` runs every subject and prints one row for each; `make trust` runs the
long version. A subject is a module of this folder without an underscore: it holds

- ``MINUTES``, how long its long version takes on one quiet core, and
- ``run(budget)``, which returns an `Outcome`, or yields several.

Nothing else has to be edited to add one.
"""
