"""An agent that tries to work out where targets will appear, from its seed, its first views, and all small numbers."""

import hashlib

SMALL_NUMBERS = 40
LOW, WIDTH = 0.5, 10.0
GOLDEN, WORD = 0x9E3779B97F4A7C15, 2**64 - 1


def mix(z):
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & WORD
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & WORD
    return z ^ (z >> 31)


def place(seed, number):
    """Rulebook A.5, A.6."""
    key = mix((mix((seed + GOLDEN) & WORD) + 2 * GOLDEN) & WORD)
    words = (mix((key + (3 * number - 2 + j) * GOLDEN) & WORD) for j in (0, 1))
    return tuple(LOW + WIDTH * (word >> 11) * 2.0**-53 for word in words)


def keyed(key, words, *numbers):
    message = b"".join(number.to_bytes(8, "little") for number in numbers)
    return int.from_bytes(hashlib.blake2b(message, digest_size=8, key=key, person=words).digest(), "little") >> 1


class Agent:
    def reset(self, seed):
        own = {seed, seed << 1 & WORD, seed << 1 & WORD | 1}
        guesses = {*own, *range(1 << 12)}  # a match's seed is one of these, or follows from one as a tournament's
        for number in (*own, *range(SMALL_NUMBERS)):
            key = hashlib.blake2b(number.to_bytes(8, "little"), digest_size=16, person=b"number").digest()
            guesses |= {keyed(key, b"match", block) for block in range(8)}
            for way in ("{}/match/{}", "match/{}/{}/0/1", "match/{}/0/0/1", "match/{}/{}"):  # as it once was
                text = way.format(number, 0).encode()
                guesses.add(int.from_bytes(hashlib.blake2b(text, digest_size=6).digest(), "little"))
        self.guesses, self.views, self.found = guesses, 0, None

    def act(self, view):
        self.views += 1
        if self.views == 1:
            seen = [
                (
                    view.x + view.heading_cos * target.forward - view.heading_sin * target.left,
                    view.y + view.heading_sin * target.forward + view.heading_cos * target.left,
                )
                for target in view.targets
            ]
            for guess in self.guesses:
                x, y = place(guess, 1)
                if any(abs(x - at_x) + abs(y - at_y) < 1e-4 for at_x, at_y in seen):
                    self.found = guess
            print("nothing found" if self.found is None else f"predicted {place(self.found, 3)}")
        return 0
