"""The output stage of a TopCon as a pure model: engineering units, `step(dt)`, no CAN."""
