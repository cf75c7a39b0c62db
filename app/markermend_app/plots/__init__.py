"""Pictures of values: nothing here computes, remembers or asks."""
