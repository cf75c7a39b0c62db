"""How things look: one table of kinds, one of colours, one stylesheet."""
