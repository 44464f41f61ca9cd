"""Engines that are commands: programs in any language that read a request and write a result.

An entry in a file ``engines.toml`` names the command and declares what the program supports. Formulation, coordinates
and integrator are the program's own. A run writes the request as JSON (:mod:`adapters.request`), starts the command,
and reads its result and the table of samples. The program's own clock counts as the run time where it gives one;
otherwise the whole process does.
"""
