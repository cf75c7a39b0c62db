"""Many takes at once: detection, and repair by an explicit policy, over a whole archive."""
