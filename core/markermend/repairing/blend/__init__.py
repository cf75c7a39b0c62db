"""Regress a marker on its neighbours in frames of reference, and krige what is left over."""
