"""Looks ahead: tries every place to go to in an arena of its own."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from catch_arena.batch_policy import BatchView
from catch_arena.policy import Limits, View

Numbers = NDArray[np.float64]


class Tuning(NamedTuple):
    steps: int = 14
    step_s: float = 0.2
    discount: float = 0.25
    rivals: float = 0.33
    lost_by_s: float = 0.4
    wait_s: float = 1.0
    share: float = 0.6
    grid: int = 3
    end: float = 1.0


class Agent:
    control = "velocity"
    tuning = Tuning()

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, view: View) -> tuple[float, float]:
        observations = np.asarray([view.observation], dtype=np.float32)
        speed, turn = self.act_batch(BatchView(observations, np.zeros((1, 0), np.int8), view.limits))[0].tolist()
        return speed, turn

    def act_batch(self, view: BatchView) -> Numbers:
        t = self.tuning
        sim = Sim(view, t)
        choice = sim.values().argmax(axis=1)
        rows = np.arange(len(choice))
        return sim.drive0(rows, choice)


class Sim:
    def __init__(self, view, t):
        self.t = t
        L = self.L = view.limits
        own, targets, rivals = view.own, view.targets, view.rivals
        f8 = np.float64
        n = len(own.x)
        K = min(L.targets_seen, 8)
        R = min(L.hunters_seen, 5)
        c, s = own.heading_cos.astype(f8)[:, None], own.heading_sin.astype(f8)[:, None]
        x, y = own.x.astype(f8)[:, None], own.y.astype(f8)[:, None]

        def world(forward, left):
            forward, left = forward.astype(f8), left.astype(f8)
            return x + c * forward - s * left, y + s * forward + c * left

        self.tx, self.ty = world(targets.forward[:, :K], targets.left[:, :K])
        self.alive = targets.present[:, :K] > 0
        rx, ry = world(rivals.forward[:, :R], rivals.left[:, :R])
        rc, rs = rivals.heading_cos[:, :R].astype(f8), rivals.heading_sin[:, :R].astype(f8)
        self.hx = np.concatenate((x, rx), 1)
        self.hy = np.concatenate((y, ry), 1)
        th0 = np.arctan2(s, c)
        self.th = np.concatenate((th0, th0 + np.arctan2(rs, rc)), 1)
        self.here = np.concatenate((np.ones((n, 1), bool), rivals.present[:, :R] > 0), 1)
        self.moving = np.concatenate((np.ones((n, 1), bool), rivals.linear_velocity[:, :R] != 0), 1)
        lo, hi = 0.5, L.side_m - 0.5889
        g = lo + (np.arange(t.grid) + 0.5) * (hi - lo) / t.grid
        gx, gy = np.repeat(g, t.grid), np.tile(g, t.grid)
        g5 = lo + (np.arange(5) + 0.5) * (hi - lo) / 5
        self.sx, self.sy = np.repeat(g5, 5), np.tile(g5, 5)
        # candidates: targets, stay, grid
        W = t.grid * t.grid + 1
        self.ax = np.concatenate((self.tx, x, np.broadcast_to(gx, (n, W - 1))), 1)
        self.ay = np.concatenate((self.ty, y, np.broadcast_to(gy, (n, W - 1))), 1)
        self.K, self.C, self.n = K, K + W, n
        d = np.hypot(self.tx[:, None] - self.hx[:, :, None], self.ty[:, None] - self.hy[:, :, None])
        d = np.where(self.here[:, :, None], d, np.inf)
        mine = (d[:, 0] < L.reach_m) & (d.argmin(1) == 0)
        self.ok = np.concatenate((self.alive & ~mine, np.ones((n, W), bool)), 1)

    def values(self):
        t, L = self.t, self.L
        n, C, K = self.n, self.C, self.K
        H = self.hx.shape[1]
        V, W, reach, dt = L.max_speed_mps, L.max_turn_rate_radps, L.reach_m, t.step_s
        hx, hy, th = (np.broadcast_to(a[:, None], (n, C, H)).copy() for a in (self.hx, self.hy, self.th))
        tx, ty = self.tx[:, None, None], self.ty[:, None, None]
        alive = np.broadcast_to(self.alive[:, None], (n, C, K)).copy()
        present = np.where(self.here, 0.0, np.inf)[:, None, :, None]
        still = np.where(self.moving, 0.0, np.inf)[:, None, :, None]
        own = np.zeros((n, C))
        others = np.zeros((n, C))
        shares = np.zeros((n, C))
        going = np.broadcast_to(np.arange(C) < K, (n, C)) & self.ok
        cand = np.minimum(np.arange(C), K - 1)
        waiting = np.arange(C) >= K
        ax, ay = self.ax, self.ay
        for step in range(t.steps):
            disc = np.exp(-t.discount * step * dt)
            dx, dy = tx - hx[..., None], ty - hy[..., None]
            dist = np.sqrt(dx * dx + dy * dy)
            near = dist + present
            least = near.min(axis=2)
            caught = (least < reach) & alive
            if caught.any():
                me = caught & (near[:, :, 0] <= least)
                own += disc * me.sum(-1)
                others += disc * (caught & ~me).sum(-1)
                alive &= ~caught
            co, si = np.cos(th)[..., None], np.sin(th)[..., None]
            bear = np.abs(np.arctan2(co * dy - si * dx, co * dx + si * dy))
            arr = np.maximum(0, dist - reach) / V + 0.5 / W * bear + present + still
            m1 = arr.min(axis=2, keepdims=True)
            first = arr <= m1
            m2 = np.where(first, np.inf, arr).min(axis=2, keepdims=True)
            late = arr - np.where(first, m2, m1)
            dead = np.where(alive, 0.0, np.inf)
            key = np.where(first, arr, 1000.0 + late) + dead[:, :, None]
            key[:, :, 0][late[:, :, 0] > t.lost_by_s] = np.inf
            goal = key.argmin(axis=-1)
            gd = np.take_along_axis(key, goal[..., None], -1)[..., 0]
            go = gd < np.inf
            gx = np.take_along_axis(np.broadcast_to(tx[:, :, 0], (n, C, K)), goal, -1)
            gy = np.take_along_axis(np.broadcast_to(ty[:, :, 0], (n, C, K)), goal, -1)
            # self: candidate
            if K:
                going = going & alive[:, np.arange(C), cand]
            follow = going | (waiting & (step * dt < t.wait_s))
            gx[:, :, 0] = np.where(follow, ax, gx[:, :, 0])
            gy[:, :, 0] = np.where(follow, ay, gy[:, :, 0])
            go[:, :, 0] |= follow
            dx, dy = gx - hx, gy - hy
            co, si = co[..., 0], si[..., 0]
            bearing = np.arctan2(co * dy - si * dx, co * dx + si * dy)
            d = np.sqrt(dx * dx + dy * dy)
            turn = np.clip(bearing, -W * dt, W * dt)
            diam = (d + reach / 2) / np.maximum(1e-6, np.abs(np.sin(bearing)))
            speed = np.minimum(np.minimum(V, W * diam / 2), d / dt)
            speed = np.where((np.abs(bearing) < np.pi / 2) & go, speed, 0.0)
            turn = np.where(go, turn, 0.0)
            mid = th + 0.5 * turn
            hx += dt * speed * np.cos(mid)
            hy += dt * speed * np.sin(mid)
            th += turn
            if t.share and step in (t.steps // 3, 2 * t.steps // 3, t.steps - 1):
                dx, dy = self.sx - hx[..., None], self.sy - hy[..., None]
                co, si = np.cos(th)[..., None], np.sin(th)[..., None]
                b = np.abs(np.arctan2(co * dy - si * dx, co * dx + si * dy))
                a = np.sqrt(dx * dx + dy * dy) / V + 0.5 / W * b + present
                shares += (a[:, :, 0] <= a.min(2)).mean(-1) / 3
        if t.end:
            first0 = arr[:, :, 0] <= m1[:, :, 0]
            e = t.end * np.exp(-t.discount * (t.steps * dt + m1[:, :, 0])) * alive
            own += (e * first0).sum(-1)
            others += (e * ~first0).sum(-1)
        self.own, self.others, self.shares = own, others, shares
        v = own - t.rivals * others + t.share * shares
        return np.where(self.ok, v, -np.inf)

    def drive0(self, rows, choice):
        L = self.L
        dx, dy = self.ax[rows, choice] - self.hx[:, 0], self.ay[rows, choice] - self.hy[:, 0]
        c, s = np.cos(self.th[:, 0]), np.sin(self.th[:, 0])
        f, l = c * dx + s * dy, c * dy - s * dx
        b = np.arctan2(l, f)
        d = np.hypot(f, l)
        turn = np.clip(6.0 * b / L.max_turn_rate_radps, -1, 1)
        diam = (d + L.reach_m / 2) / np.maximum(1e-6, np.abs(np.sin(b)))
        speed = np.minimum(1.0, L.max_turn_rate_radps * diam / 2 / L.max_speed_mps)
        wait = choice >= self.K
        speed = np.where(wait, np.minimum(speed, 2.0 * d / L.max_speed_mps), speed)
        turn = np.where(d < 0.02, 0, turn)
        return np.stack((np.where(np.abs(b) >= np.pi / 2, 0.0, speed), turn), 1)
