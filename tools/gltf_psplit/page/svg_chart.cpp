#include "tools/gltf_psplit/page/svg_chart.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "tools/gltf_psplit/page/html_text.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

constexpr double kDigit = 8.3, kLine = 16;  // the approximate width of a letter and height of a line
constexpr double kNarrowWidth = 340;        // of the narrow drawings

std::string number(double value) { return with_decimals(value, 1); }

std::string attributes(std::initializer_list<std::pair<const char*, double>> list) {
  std::string text;
  for (const auto& [name, value] : list) text += std::string(" ") + name + "=\"" + number(value) + "\"";
  return text;
}

std::string svg_line(double x1, double y1, double x2, double y2, const std::string& classes) {
  return "<line" + attributes({{"x1", x1}, {"y1", y1}, {"x2", x2}, {"y2", y2}}) + " class=\"" + classes +
         "\"/>";
}

std::string svg_text(double x, double y, const std::string& text, const char* anchor, const char* classes) {
  return html_element(
      "text", text,
      attributes({{"x", x}, {"y", y}}) + " text-anchor=\"" + anchor + "\" class=\"" + classes + "\"");
}

std::string color_class(size_t style) { return "s" + std::to_string(style % kChartColors); }

// About 10 pixels wide.
std::string shape_at(size_t shape, double x, double y) {
  constexpr const char* kShapes[] = {"a5 5 0 1 0 10 0a5 5 0 1 0 -10 0z",
                                     "v-4.5h9v9h-9z",
                                     "l5 -6 5 6 -5 6z",
                                     "v4h10l-5 -9.5z",
                                     "v-4h10l-5 9.5z",
                                     "v-2h3v-3h4v3h3v4h-3v3h-4v-3h-3z",
                                     "l3 -5h6l3 5 -3 5h-6z",
                                     "l-2 -5 6 2.5 6 -2.5 -2 5 2 5 -6 -2.5 -6 2.5z"};
  constexpr double kLeft[] = {5, 4.5, 5, 5, 5, 5, 6, 4};
  shape %= std::size(kShapes);
  return "M" + number(x - kLeft[shape]) + " " + number(y) + kShapes[shape];
}

// Maps values to pixels, and has ticks.
class Scale {
 public:
  // The axis runs from pixel `from` to pixel `to`; `from` may be larger.
  Scale(const ChartAxis& axis, std::vector<double> values, double from, double to)
      : is_logarithmic_(axis.is_logarithmic), is_count_(axis.is_count), from_(from), to_(to) {
    std::erase_if(values, [&](double v) { return !std::isfinite(v) || (is_logarithmic_ && v <= 0); });
    const auto [low, high] = std::ranges::minmax_element(values);
    const bool any = low != values.end();
    if (is_logarithmic_) {
      // Leave some room on both sides.
      low_ = std::log10(any ? *low : 1);
      high_ = std::log10(any ? *high : 10);
      const double room = std::max(0.05, 0.06 * (high_ - low_));
      low_ -= room;
      high_ += room;
      add_logarithmic_ticks();
    } else {
      // A range as small as rounding errors counts as empty.
      constexpr double kLeast = 1e-9;
      low_ = axis.start;
      high_ = any && *high - low_ > kLeast * std::max(1.0, std::abs(low_)) ? *high : low_ + 1;
      add_even_ticks(high_ - low_);
      if (ticks_.back() < high_) ticks_.push_back(ticks_.back() + step_);
      high_ = ticks_.back();
    }
  }

  double operator()(double value) const {
    double at = value;
    if (is_logarithmic_) at = value > 0 ? std::log10(value) : low_;
    if (!std::isfinite(at)) at = low_;
    return from_ + (to_ - from_) * std::clamp((at - low_) / (high_ - low_), 0.0, 1.0);
  }
  const std::vector<double>& ticks() const { return ticks_; }
  std::string tick_text(double tick) const {
    const double least = is_logarithmic_ ? (step_ > 0 ? step_ : tick) : step_;
    const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(least) + 1e-9)));
    return decimals == 0 ? with_separators(static_cast<uint64_t>(std::llround(tick)))
                         : with_decimals(tick, decimals);
  }

 private:
  void add_even_ticks(double range) {
    const double power = std::pow(10, std::floor(std::log10(range / 4)));
    step_ = power;
    for (const double factor : {2, 5, 10})
      if (range / step_ > 6) step_ = factor * power;
    if (is_count_) step_ = std::max(step_, 1.0);
    const double low = is_logarithmic_ ? std::pow(10, low_) : low_;
    for (double i = std::ceil(low / step_ - 1e-9); i * step_ <= low + range * (1 + 1e-9); ++i)
      ticks_.push_back(i * step_ + 0.0);  // no -0
  }
  void add_logarithmic_ticks() {
    constexpr double kFew = 1.2, kMany = 2.5;  // powers of ten
    if (high_ - low_ < kFew / 2) return add_even_ticks(std::pow(10, high_) - std::pow(10, low_));
    for (double power = std::floor(low_); power <= high_; ++power)
      for (const double factor : {1, 2, 5}) {
        const double exponent = power + std::log10(factor);
        if (factor > 1 && high_ - low_ > 2 * kMany) continue;
        if (exponent >= low_ && exponent <= high_) ticks_.push_back(factor * std::pow(10, power));
      }
  }

  bool is_logarithmic_, is_count_;
  double from_, to_;
  double low_ = 0, high_ = 1;  // logarithms on a logarithmic scale
  double step_ = 0;            // between evenly spaced ticks
  std::vector<double> ticks_;
};

struct Box {
  double x, y, width, height;
};

bool is_free(const Box& box, const std::vector<Box>& taken) {
  return std::ranges::none_of(taken, [&](const Box& other) {
    return box.x < other.x + other.width && other.x < box.x + box.width && box.y < other.y + other.height &&
           other.y < box.y + box.height;
  });
}

enum class Drawing { kWide, kNarrow };

std::string figure(const std::string& id, const std::string& title, const std::string& note,
                   const std::string& legend, const std::string& drawings) {
  return "<figure class=\"chart\" id=\"" + escape_html(id) + "\"><figcaption>" + escape_html(title) +
         (note.empty() ? "" : html_element("small", note)) + "</figcaption><ul class=\"legend\">" + legend +
         "</ul><div class=\"plot\">" + drawings + "</div></figure>\n";
}

std::string legend_item(double width, const std::string& svg, const std::string& name) {
  return "<li><svg width=\"" + number(width) + "\" height=\"14\" aria-hidden=\"true\">" + svg + "</svg>" +
         escape_html(name) + "</li>";
}

std::string reference_entry(const std::optional<ChartReference>& reference) {
  return reference ? legend_item(22, svg_line(0, 7, 22, 7, "reference"), reference->label) : "";
}

std::string style_classes(const ChartStyle& style) {
  return color_class(style.color) + (style.is_hollow ? " hollow" : "");
}

std::string begin_svg(Drawing drawing, const std::string& title, double width, double height) {
  return "<svg class=\"" + std::string(drawing == Drawing::kWide ? "wide" : "narrow") + "\"" +
         attributes({{"width", width}, {"height", height}}) + " viewBox=\"0 0 " + number(width) + " " +
         number(height) + "\" role=\"img\" aria-label=\"" + escape_html(title) + "\">";
}

// The rectangle of the marks, inside axes and titles.
struct Area {
  double left, top, right, bottom;
};

// Grid, ticks and title of the horizontal axis. A label that would touch the previous one is left out.
std::string draw_x_axis(const Scale& scale, const ChartAxis& axis, const Area& area) {
  std::string svg;
  double free_from = 0;
  for (const double tick : scale.ticks()) {
    const double x = scale(tick);
    svg += svg_line(x, area.top, x, area.bottom, "grid");
    const std::string text = scale.tick_text(tick);
    const double half = kDigit * static_cast<double>(text.size()) / 2;
    if (x - half < free_from || x + half > area.right + kLine) continue;
    free_from = x + half + kDigit;
    svg += svg_text(x, area.bottom + kLine + 2, text, "middle", "tick");
  }
  svg += svg_line(area.left, area.bottom, area.right, area.bottom, "axis");
  return svg + svg_text((area.left + area.right) / 2, area.bottom + 2.6 * kLine, axis.title, "middle", "title");
}

std::string draw_y_axis(const Scale& scale, const ChartAxis& axis, const Area& area) {
  std::string svg;
  for (const double tick : scale.ticks()) {
    const double y = scale(tick);
    svg += svg_line(area.left, y, area.right, y, "grid");
    svg += svg_text(area.left - 8, y + 4.5, scale.tick_text(tick), "end", "tick");
  }
  return svg + svg_text(8, area.top - 14, axis.title, "start", "title");
}

using Corners = std::vector<std::pair<double, double>>;

std::string polyline(const Corners& corners, const std::string& classes) {
  std::string points;
  for (const auto& [x, y] : corners) points += number(x) + "," + number(y) + " ";
  return "<polyline class=\"" + classes + "\" points=\"" + points + "\"/>";
}

// Left of and above these corners is what the points of the front beat.
Corners front_corners(const std::vector<const ChartPoint*>& front, const Scale& x, const Scale& y,
                      const Area& area) {
  Corners corners;
  double from = area.left;
  for (const ChartPoint* point : front) {
    corners.emplace_back(from, y(point->y));
    corners.emplace_back(from = x(point->x), y(point->y));
  }
  corners.emplace_back(from, area.top);
  return corners;
}

Corners line_corners(const ChartSeries& series, const Scale& x, const Scale& y) {
  Corners corners;
  for (const ChartPoint& point : series.points) corners.emplace_back(x(point.x), y(point.y));
  return corners;
}

std::string draw_series(const ChartSeries& series, const Scale& x, const Scale& y) {
  std::string svg = "<g class=\"" + color_class(series.style.color) + "\">";
  if (series.points.size() > 1)
    svg += polyline(line_corners(series, x, y), series.style.is_dashed ? "line dashed" : "line");
  for (const ChartPoint& point : series.points)
    if (point.spread)
      svg += svg_line(x(point.spread->low_x), y(point.spread->low_y), x(point.spread->high_x),
                      y(point.spread->high_y), "spread");
  for (const ChartPoint& point : series.points) {
    const double at_x = x(point.x), at_y = y(point.y);
    if (point.is_noisy)
      svg += "<circle class=\"ring\"" + attributes({{"cx", at_x}, {"cy", at_y}, {"r", 9}}) + "/>";
    svg += "<path class=\"mark " + style_classes(series.style) + "\" d=\"" +
           shape_at(series.style.shape, at_x, at_y) + "\">" + html_element("title", point.title) + "</path>";
  }
  return svg + "</g>";
}

// Puts each tag beside its mark, where it hides no mark and no other text, and best no line. A tag without such
// a place is left out: the mark's title and the tables have its text.
class Tags {
 public:
  Tags(const XyChart& chart, const Scale& x, const Scale& y, const Area& area) : x_(x), y_(y), area_(area) {
    taken_.push_back({0, 0, 8 + kDigit * static_cast<double>(chart.y.title.size()), area.top - 10});
    for (const ChartSeries& series : chart.series) {
      add_line(line_corners(series, x, y));
      for (const ChartPoint& point : series.points) {
        const double reach = reach_of(point);
        taken_.push_back({x(point.x) - reach, y(point.y) - reach, 2 * reach, 2 * reach});
        if (const auto& spread = point.spread)
          add_line({{x(spread->low_x), y(spread->low_y)}, {x(spread->high_x), y(spread->high_y)}});
      }
    }
  }
  // A line is treated as a row of dots.
  void add_line(const Corners& corners) {
    constexpr double kDots = 5;
    for (size_t i = 1; i < corners.size(); ++i) {
      const auto [x1, y1] = corners[i - 1];
      const auto [x2, y2] = corners[i];
      const double steps = std::ceil(std::hypot(x2 - x1, y2 - y1) / kDots);
      for (double step = 1; step < steps; ++step)
        lines_.push_back({std::lerp(x1, x2, step / steps), std::lerp(y1, y2, step / steps), 1, 1});
    }
  }
  std::string draw(const ChartPoint& point) {
    if (point.tag.empty()) return "";
    const double width = kDigit * static_cast<double>(point.tag.size()), height = 13;
    const double at_x = x_(point.x), at_y = y_(point.y), reach = reach_of(point);
    const double above = at_y - reach - height, beside = at_y - height / 2, below = at_y + reach;
    const double right = at_x + reach + 1, centred = at_x - width / 2, left_of = at_x - reach - 1 - width;
    const std::pair<double, double> places[] = {{right, beside},      {centred, above},    {centred, below},
                                                {left_of, beside},    {right - 4, above},  {right - 4, below},
                                                {left_of + 4, above}, {left_of + 4, below}};
    for (const bool may_cross_lines : {false, true})
      for (const auto& [left, top] : places) {
        const Box box{left, top, width, height};
        const bool is_inside = left > area_.left && left + width < area_.right + 12 &&
                               top > area_.top - kLine && top + height < area_.bottom;
        if (!is_inside || !is_free(box, taken_) || !(may_cross_lines || is_free(box, lines_))) continue;
        taken_.push_back(box);
        return svg_text(left + width / 2, top + height - 2.5, point.tag, "middle", "tag");
      }
    return "";
  }

 private:
  static double reach_of(const ChartPoint& point) { return point.is_noisy ? 10 : 7; }

  const Scale &x_, &y_;
  const Area& area_;
  std::vector<Box> taken_, lines_;
};

std::string draw(const XyChart& chart, Drawing drawing) {
  const double width = drawing == Drawing::kWide ? chart.width : kNarrowWidth;
  const double height = drawing == Drawing::kWide ? chart.height : 0.7 * chart.height;
  std::vector<double> xs, ys;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      xs.push_back(point.x);
      ys.push_back(point.y);
    }
  if (chart.reference) ys.push_back(chart.reference->value);
  Area area{0, 34, width - 16, height - 50};
  const Scale y(chart.y, std::move(ys), area.bottom, area.top);
  size_t widest = 0;
  for (const double tick : y.ticks()) widest = std::max(widest, y.tick_text(tick).size());
  area.left = 16 + kDigit * static_cast<double>(widest);
  const Scale x(chart.x, std::move(xs), area.left, area.right);

  std::string svg = begin_svg(drawing, chart.title, width, height) + draw_y_axis(y, chart.y, area) +
                    draw_x_axis(x, chart.x, area);
  if (chart.reference) {
    const double at = y(chart.reference->value);
    svg += svg_line(area.left, at, area.right, at, "reference");
  }
  Tags tags(chart, x, y, area);
  std::vector<const ChartPoint*> tagged;
  if (!chart.front.empty()) {
    tagged = front_of(chart);
    const Corners corners = front_corners(tagged, x, y, area);
    svg += polyline(corners, "front");
    tags.add_line(corners);
  }
  for (const ChartSeries& series : chart.series) {
    svg += draw_series(series, x, y);
    for (const ChartPoint& point : series.points)
      if (std::ranges::find(tagged, &point) == tagged.end()) tagged.push_back(&point);
  }
  for (const ChartPoint* point : tagged) svg += tags.draw(*point);
  return svg + "</svg>";
}

// In the narrow drawing a bar's name is above it.
std::string draw(const BarChart& chart, Drawing drawing) {
  const bool is_wide = drawing == Drawing::kWide;
  const double width = is_wide ? 680 : kNarrowWidth, bar_height = 18, step = is_wide ? 28 : 44;
  size_t longest = 0, longest_total = 0;
  std::vector<double> sums;
  for (const BarChart::Bar& bar : chart.bars) {
    longest = std::max(longest, bar.name.size());
    longest_total = std::max(longest_total, bar.total.size());
    sums.push_back(std::accumulate(bar.values.begin(), bar.values.end(), 0.0));
  }
  if (chart.reference) sums.push_back(chart.reference->value);
  const double height = 14 + step * static_cast<double>(chart.bars.size()) + 52;
  const Area area{is_wide ? 12 + kDigit * static_cast<double>(longest) : 12, 6,
                  width - 12 - kDigit * static_cast<double>(longest_total), height - 50};
  const ChartAxis axis{chart.axis_title};
  const Scale scale(axis, std::move(sums), area.left, area.right);

  std::string svg = begin_svg(drawing, chart.title, width, height) + draw_x_axis(scale, axis, area);
  double top = area.top + 6;
  for (const BarChart::Bar& bar : chart.bars) {
    const double name_y = is_wide ? top + bar_height - 4.5 : top + 13;
    svg += svg_text(is_wide ? area.left - 8 : area.left, name_y, bar.name, is_wide ? "end" : "start", "tick");
    const double bar_top = is_wide ? top : top + step - bar_height - 6;
    double sum = 0;
    for (size_t i = 0; i < bar.values.size(); ++i) {
      const double left = scale(sum), right = scale(sum += bar.values[i]);
      const bool is_noisy = i < bar.noisy.size() && bar.noisy[i];
      const std::string what = bar.name + ", " + chart.parts[i] + ": " + (is_noisy ? "about " : "") +
                               with_decimals(bar.values[i], 3) + " " + chart.unit;
      svg += "<rect class=\"mark bar " + color_class(i) + (is_noisy ? " noisy" : "") + "\"" +
             attributes({{"x", left}, {"y", bar_top}, {"width", right - left}, {"height", bar_height}}) + ">" +
             html_element("title", what) + "</rect>";
    }
    // The total stands after the reference if it would cross it.
    double end = scale(sum);
    if (const double at = chart.reference ? scale(chart.reference->value) : 0;
        at < end + 6 + kDigit * static_cast<double>(bar.total.size()))
      end = std::max(end, at);
    svg += svg_text(end + 6, bar_top + bar_height - 4.5, bar.total, "start", "tick");
    top += step;
  }
  if (chart.reference) {
    const double at = scale(chart.reference->value);
    svg += svg_line(at, area.top, at, area.bottom, "reference");
  }
  return svg + "</svg>";
}

}  // namespace

std::vector<const ChartPoint*> front_of(const XyChart& chart) {
  std::vector<const ChartPoint*> points, front;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points)
      if (std::isfinite(point.x) && std::isfinite(point.y)) points.push_back(&point);
  // From the right, and of points as far right the lowest first: a point is on the front if it is lower than
  // all before it.
  std::ranges::stable_sort(points, {}, [](const ChartPoint* point) { return std::pair(-point->x, point->y); });
  for (const ChartPoint* point : points)
    if (front.empty() || point->y < front.back()->y) front.push_back(point);
  std::ranges::reverse(front);
  return front;
}

std::string draw_chart(const XyChart& chart, const std::string& noisy) {
  std::string legend;
  bool is_noisy = false;
  for (const ChartSeries& series : chart.series) {
    legend += legend_item(14,
                          "<path class=\"key " + style_classes(series.style) + "\" d=\"" +
                              shape_at(series.style.shape, 7, 7) + "\"/>",
                          series.name);
    is_noisy = is_noisy || std::ranges::any_of(series.points, &ChartPoint::is_noisy);
  }
  legend += reference_entry(chart.reference);
  if (!chart.front.empty()) legend += legend_item(22, svg_line(0, 7, 22, 7, "front"), chart.front);
  if (is_noisy) legend += legend_item(14, "<circle class=\"ring\" cx=\"7\" cy=\"7\" r=\"6\"/>", noisy);
  return figure(chart.id, chart.title, chart.note, legend,
                draw(chart, Drawing::kWide) + draw(chart, Drawing::kNarrow));
}

std::string draw_chart(const BarChart& chart, const std::string& noisy) {
  constexpr const char* kSquare = "d=\"M1 1h12v12h-12z\"/>";
  std::string legend;
  for (size_t i = 0; i < chart.parts.size(); ++i)
    legend += legend_item(14, "<path class=\"key " + color_class(i) + "\" " + kSquare, chart.parts[i]);
  legend += reference_entry(chart.reference);
  const auto has_noise = [](const BarChart::Bar& bar) { return std::ranges::count(bar.noisy, true) > 0; };
  if (std::ranges::any_of(chart.bars, has_noise))
    legend += legend_item(14, "<path class=\"key noisy s0\" " + std::string(kSquare), noisy);
  return figure(chart.id, chart.title, chart.note, legend,
                draw(chart, Drawing::kWide) + draw(chart, Drawing::kNarrow));
}

}  // namespace psplit
