"""What the estimate means for the cell: contact mode, transition, jamming risk, alarms."""
