"""Many takes at once: detection, and repair by an explicit policy, over a whole archive.

`run` does it, `overview` says how the archive looks then, `policy` is what may be repaired.
Importing this package loads no database library: the processes that work on takes need none.
"""
