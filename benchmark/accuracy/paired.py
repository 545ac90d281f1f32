"""Exact paired tests of small samples, without any library."""


def signed_rank(differences):
    """Two-sided p of Wilcoxon's signed-rank test: exact over all signs, mid-ranks for ties, zeros left out.

    1.0 without a difference.
    """
    values = sorted((value for value in differences if value), key=abs)
    if not values:
        return 1.0
    # Twice the mid-ranks, so that they are whole numbers.
    ranks, at = [0] * len(values), 0
    while at < len(values):
        end = at
        while end < len(values) and abs(values[end]) == abs(values[at]):
            end += 1
        ranks[at:end] = [at + end + 1] * (end - at)
        at = end
    total = sum(ranks)
    ways = [1] + [0] * total  # in how many of all signs the positive ranks sum to this
    for rank in ranks:
        for value in range(total, rank - 1, -1):
            ways[value] += ways[value - rank]
    positive = sum(rank for rank, value in zip(ranks, values) if value > 0)
    tail = min(positive, total - positive)
    return min(1.0, 2.0 * sum(ways[:tail + 1]) / 2 ** len(values))


def holm(probabilities):
    """p of each of several tests, adjusted so that the chance of any false finding stays what one test promises."""
    order = sorted(range(len(probabilities)), key=lambda index: probabilities[index])
    adjusted, least = [1.0] * len(probabilities), 0.0
    for place, index in enumerate(order):
        least = max(least, min(1.0, (len(probabilities) - place) * probabilities[index]))
        adjusted[index] = least
    return adjusted
