"""
From messages to rows: their order, the filter and the monitor, and what is asked of them.

`pipeline` has samples and requests (tare, reset, expected motions). `engine` puts messages in
their order and goes back for late ones. `push` is the compiled loop over them, in which `steps`
processes one orientation or one wrench. `processor` has the settings and the state for that.
"""
