"""Types of the records that compiled code takes: each of the dtype that its comment names."""

from typing import Any, NewType


class Record:
    """A NumPy record whose fields are attributes, as compiled code has them."""

    def __getattr__(self, field: str) -> Any:
        """Return a field."""

    def __setattr__(self, field: str, value: Any) -> None:
        """Change a field."""


FreshnessRecord = NewType("FreshnessRecord", Record)  # measurements.freshness.FRESHNESS
InnovationsRecord = NewType("InnovationsRecord", Record)  # measurements.innovations.INNOVATIONS
ReductionRecord = NewType("ReductionRecord", Record)  # measurements.measurement.REDUCTION
RulesRecord = NewType("RulesRecord", Record)  # engine.state.RULES
EngineRecord = NewType("EngineRecord", Record)  # engine.state.ENGINE
PlacesRecord = NewType("PlacesRecord", Record)  # engine.ring.PLACES
OrderRecord = NewType("OrderRecord", Record)  # engine.arrival_order.ORDER
TakingRecord = NewType("TakingRecord", Record)  # engine.push.TAKING
