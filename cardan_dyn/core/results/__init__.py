"""Results: motion and wrenches as their users read them."""
