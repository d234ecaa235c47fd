"""
Methods: the estimators that `filter.method` offers, one module for each.

A member has a module of its name here, with the same interface:

`METHOD` : method.Method
    With `make(scene, options, wrench_noise, offsets)`, which returns the estimator. That is a
    `ContactFilter`, or a class that derives from it: such a one is called step by step from
    Python, where a plain one runs in the compiled call of the engine.
`SETTINGS` : dict
    Of a member that is a `ContactFilter` with something left out: the settings of the estimator
    that differ from the default ones, of which `method.of_settings` makes `METHOD`.

`registry` is the only place that lists them. Node, replay and studies make an estimator by
`registry.make_filter`, from the options alone.

To add a member, touch these files: a module here, `registry.py` (its line), and
`config/parameter_table.py` (its name in METHODS with a few words, from which the parameter's
choices and its explanation follow).
"""
