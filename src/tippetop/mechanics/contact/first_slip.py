def first_direction(u, L, b):
    return None
def leave_rolling(u, L, b):
    raise NotImplementedError
