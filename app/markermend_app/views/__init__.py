"""The parts of the page: they show values of the desk and send intentions."""
