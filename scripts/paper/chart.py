"""Figure 12 as an SVG: speed-ups over the number of patches, one line for each model."""
from paper.models import kModels
from paper.page import decode_of, decoder_name, decoders, kCodings, run_name

kColors = ("#1f6feb", "#d1242f", "#1a7f37", "#9a6700")
kWidth, kHeight, kGap, kLeft, kTop = 300, 220, 60, 50, 40


def lines_of(results, coding):
    """(title, color, dashed, speed-ups) of each model."""
    decoder = decoders(results)[-1]
    for model, color in zip(kModels, kColors):
        runs = results["models"][model.name]["runs"]
        for refined in (True, False) if model.unprocessed else (True,):
            splits = runs[run_name(coding, refined)]["splits"]
            title = model.title + ("" if refined else " (*)")
            yield title, color, not refined, [decode_of(split, decoder)["speedup"] for split in splits]


def chart(results):
    most = max(value for coding in kCodings for *_, values in lines_of(results, coding) for value in values)
    # About four steps, which are round numbers.
    step = next(s * 10 ** e for e in range(-3, 6) for s in (1, 2, 5) if s * 10 ** e * 5 >= most)
    top = step * (int(most / step) + 1)
    parts = []

    def text(x, y, words, anchor="middle", color="#444"):
        parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{color}">{words}</text>')

    for panel, coding in enumerate(kCodings):
        left = kLeft + panel * (kWidth + kGap)

        def place(i, value):
            return left + 30 + i * (kWidth - 60) / (len(results["patches"]) - 1), kTop + kHeight * (1 - value / top)

        text(left + kWidth / 2, kTop - 18, f"{coding}, {decoder_name(*decoders(results)[-1])}", color="#000")
        for n in range(round(top / step) + 1):
            y = place(0, n * step)[1]
            parts.append(f'<path d="M{left} {y:.1f}h{kWidth}" stroke="#ddd"/>')
            text(left - 6, y + 4, f"{n * step:g}x", "end")
        for i, count in enumerate(results["patches"]):
            text(place(i, 0)[0], kTop + kHeight + 18, f"{count:,}")
        for title, color, dashed, values in lines_of(results, coding):
            points = " ".join("{:.1f},{:.1f}".format(*place(i, value)) for i, value in enumerate(values))
            dash = ' stroke-dasharray="5 4"' if dashed else ""
            parts.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="2"{dash}/>')
    x = kLeft
    for title, color, dashed, _ in lines_of(results, kCodings[0]):
        text(x, kTop + kHeight + 48, title, "start", color)
        x += 25 + 7 * len(title)
    width, height = kLeft + 2 * kWidth + kGap + 20, kTop + kHeight + 60
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            'font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>\n'
            + "\n".join(parts) + "\n</svg>\n")
