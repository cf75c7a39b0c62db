"""One file per format; each holds a `Format` named FORMAT, and the folder is the list."""
