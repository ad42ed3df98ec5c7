#!/usr/bin/env python3
"""FLIP and SSIM of small patterns as their papers define them, by sums over whole two-dimensional kernels in double
precision: the numbers that flip_test.cpp and image_measures_test.cpp expect. Needs nothing but Python."""
import math

# FLIP: Andersson et al. 2020; constants as in the authors' flip.py.
W, H = 24, 18
PPD = 0.7 * (3840 / 0.7) * math.pi / 180
TO_XYZ = [[10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
          [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
          [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382]]


def reference(x, y):
    return (0.5 + 0.4 * math.sin(0.9 * x + 0.3 * y), 0.5 + 0.3 * math.cos(0.4 * x - 0.7 * y),
            0.1 + 0.8 * ((x * 7 + y * 5) % 11) / 10.0)


def test(x, y):
    r, g, b = reference(x, y)
    if 8 <= x < 14 and 5 <= y < 11:
        return (min(r + 0.2, 1.0), g * 0.6, b)
    return (r, g, b * 0.9)


def linear(c):
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def inverse(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    rows = [[e * i - f * h, c * h - b * i, b * f - c * e], [f * g - d * i, a * i - c * g, c * d - a * f],
            [d * h - e * g, b * g - a * h, a * e - b * d]]
    return [[v / det for v in row] for row in rows]


def multiply(m, v):
    return [sum(m[r][k] * v[k] for k in range(3)) for r in range(3)]


TO_RGB = inverse(TO_XYZ)
WHITE = multiply(TO_XYZ, [1, 1, 1])


def ycxcz(rgb):
    x, y, z = [p / q for p, q in zip(multiply(TO_XYZ, rgb), WHITE)]
    return [116 * y - 16, 500 * (x - y), 200 * (y - z)]


def rgb_of(v):
    y = (v[0] + 16) / 116
    return multiply(TO_RGB, [(v[1] / 500 + y) * WHITE[0], y * WHITE[1], (y - v[2] / 200) * WHITE[2]])


def hunt_lab(rgb):
    d = 6 / 29
    x, y, z = [t ** (1 / 3) if t > d ** 3 else t / (3 * d * d) + 4 / 29
               for t in (p / q for p, q in zip(multiply(TO_XYZ, rgb), WHITE))]
    l = 116 * y - 16
    return [l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)]


def hyab(p, q):
    return abs(p[0] - q[0]) + math.hypot(p[1] - q[1], p[2] - q[2])


def filtered(plane, kernel):
    r = len(kernel) // 2
    clamp = lambda v, n: min(max(v, 0), n - 1)
    return [[sum(kernel[j + r][i + r] * plane[clamp(y + j, H)][clamp(x + i, W)]
                 for j in range(-r, r + 1) for i in range(-r, r + 1)) for x in range(W)] for y in range(H)]


def kernel_of(radius, f):
    return [[f(i, j) for i in range(-radius, radius + 1)] for j in range(-radius, radius + 1)]


def sensitivity(a1, b1, a2, b2):
    def g(i, j):
        z = (i / PPD) ** 2 + (j / PPD) ** 2
        return (a1 * math.sqrt(math.pi / b1) * math.exp(-math.pi ** 2 * z / b1) +
                a2 * math.sqrt(math.pi / b2) * math.exp(-math.pi ** 2 * z / b2))
    k = kernel_of(math.ceil(3 * math.sqrt(0.04 / (2 * math.pi ** 2)) * PPD), g)
    total = sum(map(sum, k))
    return [[v / total for v in row] for row in k]


def feature(kind):
    sd = 0.5 * 0.082 * PPD
    def g(i, j):
        return math.exp(-(i * i + j * j) / (2 * sd * sd)) * (-i if kind == 'edge' else i * i / (sd * sd) - 1)
    k = kernel_of(math.ceil(3 * sd), g)
    positive = sum(v for row in k for v in row if v > 0)
    negative = -sum(v for row in k for v in row if v < 0)
    return [[v / negative if v < 0 else v / positive for v in row] for row in k]


def seen(picture):
    image = [[ycxcz([linear(c) for c in picture(x, y)]) for x in range(W)] for y in range(H)]
    kernels = [sensitivity(1, 0.0047, 0, 1e-5), sensitivity(1, 0.0053, 0, 1e-5), sensitivity(34.1, 0.04, 13.5, 0.025)]
    blurred = [filtered([[image[y][x][c] for x in range(W)] for y in range(H)], kernels[c]) for c in range(3)]
    lab = [[hunt_lab([min(max(v, 0), 1) for v in rgb_of([blurred[c][y][x] for c in range(3)])]) for x in range(W)]
           for y in range(H)]
    luminance = [[(image[y][x][0] + 16) / 116 for x in range(W)] for y in range(H)]
    features = []
    for kind in ('edge', 'point'):
        k = feature(kind)
        gx, gy = filtered(luminance, k), filtered(luminance, [list(c) for c in zip(*k)])
        features.append([[math.hypot(gx[y][x], gy[y][x]) for x in range(W)] for y in range(H)])
    return lab, features


def flip():
    (lab_a, feat_a), (lab_b, feat_b) = seen(test), seen(reference)
    largest = hyab(hunt_lab([0, 1, 0]), hunt_lab([0, 0, 1])) ** 0.7
    print('c_max', largest)
    out = {}
    for y in range(H):
        for x in range(W):
            d = hyab(lab_a[y][x], lab_b[y][x]) ** 0.7
            knee = 0.4 * largest
            colour = 0.95 / knee * d if d < knee else 0.95 + (d - knee) / (largest - knee) * 0.05
            f = max(abs(feat_a[k][y][x] - feat_b[k][y][x]) for k in (0, 1))
            out[x, y] = colour ** (1 - min((f / math.sqrt(2)) ** 0.5, 1))
    for p in ((0, 0), (8, 5), (11, 8), (14, 11), (23, 17), (3, 15)):
        print('flip at', p, out[p])
    print('mean flip', sum(out.values()) / (W * H))


# SSIM: Wang et al. 2004, over the windows that lie in the picture.
def ssim(width=15, height=13):
    a = [[0.5 + 0.3 * math.sin(0.9 * x + 0.3 * y) for x in range(width)] for y in range(height)]
    b = [[0.45 + 0.25 * math.sin(0.9 * x + 0.3 * y + 0.4) for x in range(width)] for y in range(height)]
    k = kernel_of(5, lambda i, j: math.exp(-(i * i + j * j) / (2 * 1.5 ** 2)))
    total = sum(map(sum, k))
    values = []
    for y in range(5, height - 5):
        for x in range(5, width - 5):
            w = [(k[j][i] / total, a[y + j - 5][x + i - 5], b[y + j - 5][x + i - 5]) for j in range(11) for i in range(11)]
            ma, mb = sum(p * q for p, q, _ in w), sum(p * r for p, _, r in w)
            va, vb = sum(p * (q - ma) ** 2 for p, q, _ in w), sum(p * (r - mb) ** 2 for p, _, r in w)
            cov = sum(p * (q - ma) * (r - mb) for p, q, r in w)
            values.append((2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4)))
    print('mean ssim', sum(values) / len(values))


flip()
ssim()
