"""The doors for learning: PettingZoo's parallel and AEC environments over the engine."""
