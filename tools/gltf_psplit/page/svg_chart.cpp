#include "tools/gltf_psplit/page/svg_chart.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/gltf_psplit/page/html_text.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

constexpr double kWidth = 680, kDigit = 8.3,
                 kLine = 16;  // the approximate width of a letter and height of a line

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

// Each style has a shape, about 10 pixels wide, so that styles do not differ in colour alone.
std::string shape_at(size_t style, double x, double y) {
  constexpr const char* kShapes[] = {"a5 5 0 1 0 10 0a5 5 0 1 0 -10 0z",
                                     "v-4.5h9v9h-9z",
                                     "l5 -6 5 6 -5 6z",
                                     "v4h10l-5 -9.5z",
                                     "v-4h10l-5 9.5z",
                                     "v-2h3v-3h4v3h3v4h-3v3h-4v-3h-3z"};
  constexpr double kLeft[] = {5, 4.5, 5, 5, 5, 5};
  const size_t shape = style % std::size(kShapes);
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

// The boxes that are taken by text or marks.
class Occupied {
 public:
  struct Box {
    double x, y, width, height;
  };
  bool take(const Box& box) {
    for (const Box& other : boxes_)
      if (box.x < other.x + other.width && other.x < box.x + box.width && box.y < other.y + other.height &&
          other.y < box.y + box.height)
        return false;
    boxes_.push_back(box);
    return true;
  }
  void add(const Box& box) { boxes_.push_back(box); }

 private:
  std::vector<Box> boxes_;
};

std::string figure(const std::string& id, const std::string& title, const std::string& note,
                   const std::string& legend, const std::string& svg) {
  return "<figure class=\"chart\" id=\"" + escape_html(id) + "\"><figcaption>" + escape_html(title) +
         (note.empty() ? "" : html_element("small", note)) + "</figcaption><ul class=\"legend\">" + legend +
         "</ul>" + scrolling_region("plot", title, svg) + "</figure>\n";
}

std::string reference_entry(const std::optional<ChartReference>& reference) {
  if (!reference) return "";
  return "<li><svg width=\"22\" height=\"14\" aria-hidden=\"true\">" + svg_line(0, 7, 22, 7, "reference") +
         "</svg>" + escape_html(reference->label) + "</li>";
}

std::string legend_entry(size_t style, const std::string& name, bool is_bar) {
  const std::string shape = is_bar ? "M1 1h12v12h-12z" : shape_at(style, 7, 7);
  return "<li><svg width=\"14\" height=\"14\" aria-hidden=\"true\"><path class=\"key " + color_class(style) +
         "\" d=\"" + shape + "\"/></svg>" + escape_html(name) + "</li>";
}

std::string begin_svg(const std::string& title, double height) {
  return "<svg viewBox=\"0 0 " + number(kWidth) + " " + number(height) + "\" role=\"img\" aria-label=\"" +
         escape_html(title) + "\">";
}

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
    if (x - half < free_from || x + half > kWidth) continue;
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

std::string draw_series(const ChartSeries& series, const Scale& x, const Scale& y) {
  std::string svg = "<g class=\"" + color_class(series.style) + "\">";
  if (series.has_line && series.points.size() > 1) {
    svg += "<polyline class=\"line\" points=\"";
    for (const ChartPoint& point : series.points) svg += number(x(point.x)) + "," + number(y(point.y)) + " ";
    svg += "\"/>";
  }
  for (const ChartPoint& point : series.points)
    if (point.spread)
      svg += svg_line(x(point.spread->low_x), y(point.spread->low_y), x(point.spread->high_x),
                      y(point.spread->high_y), "spread");
  for (const ChartPoint& point : series.points)
    svg += "<path class=\"mark\" d=\"" + shape_at(series.style, x(point.x), y(point.y)) + "\">" +
           html_element("title", point.title) + "</path>";
  return svg + "</g>";
}

// Puts each tag beside its mark, where it hides nothing. Otherwise the tag is left out: the mark's title and
// the tables have its text.
std::string draw_tags(const XyChart& chart, const Scale& x, const Scale& y, const Area& area) {
  constexpr double kReach = 7;  // from the centre of a mark
  std::string svg;
  Occupied occupied;
  occupied.add({0, 0, 8 + kDigit * static_cast<double>(chart.y.title.size()), area.top - 10});
  const auto add_line = [&](double x1, double y1, double x2, double y2) {
    constexpr double kDots = 5;  // a line is treated as a row of dots
    const double steps = std::ceil(std::hypot(x2 - x1, y2 - y1) / kDots);
    for (double step = 1; step < steps; ++step)
      occupied.add({std::lerp(x1, x2, step / steps), std::lerp(y1, y2, step / steps), 1, 1});
  };
  for (const ChartSeries& series : chart.series)
    for (size_t i = 0; i < series.points.size(); ++i) {
      const ChartPoint& point = series.points[i];
      const double at_x = x(point.x), at_y = y(point.y);
      occupied.add({at_x - kReach, at_y - kReach, 2 * kReach, 2 * kReach});
      if (point.spread)
        add_line(x(point.spread->low_x), y(point.spread->low_y), x(point.spread->high_x),
                 y(point.spread->high_y));
      if (series.has_line && i > 0) add_line(x(series.points[i - 1].x), y(series.points[i - 1].y), at_x, at_y);
    }
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      if (point.tag.empty()) continue;
      const double width = kDigit * static_cast<double>(point.tag.size()), height = 13;
      const double at_x = x(point.x), at_y = y(point.y);
      const double above = at_y - kReach - height, beside = at_y - height / 2, below = at_y + kReach;
      const double right = at_x + kReach + 1, centred = at_x - width / 2, left_of = at_x - kReach - 1 - width;
      const std::pair<double, double> places[] = {{centred, above},     {right, beside},     {centred, below},
                                                  {left_of, beside},    {right - 4, above},  {right - 4, below},
                                                  {left_of + 4, above}, {left_of + 4, below}};
      for (const auto& [left, top] : places) {
        const bool is_inside = left > area.left && left + width < area.right + 12 &&
                               top > area.top - 2 * kLine && top + height < area.bottom;
        if (!is_inside || !occupied.take({left, top, width, height})) continue;
        svg += svg_text(left + width / 2, top + height - 2.5, point.tag, "middle",
                        ("tag " + color_class(series.style)).c_str());
        break;
      }
    }
  return svg;
}

}  // namespace

std::string draw_chart(const XyChart& chart) {
  constexpr double kHeight = 380;
  const Area area{64, 34, kWidth - 16, kHeight - 50};
  std::vector<double> xs, ys;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      xs.push_back(point.x);
      ys.push_back(point.y);
    }
  if (chart.reference) ys.push_back(chart.reference->value);
  const Scale x(chart.x, std::move(xs), area.left, area.right);
  const Scale y(chart.y, std::move(ys), area.bottom, area.top);

  std::string legend;
  for (const ChartSeries& series : chart.series) legend += legend_entry(series.style, series.name, false);
  legend += reference_entry(chart.reference);
  std::string svg =
      begin_svg(chart.title, kHeight) + draw_y_axis(y, chart.y, area) + draw_x_axis(x, chart.x, area);
  if (chart.reference) {
    const double at = y(chart.reference->value);
    svg += svg_line(area.left, at, area.right, at, "reference");
  }
  for (const ChartSeries& series : chart.series) svg += draw_series(series, x, y);
  svg += draw_tags(chart, x, y, area) + "</svg>";
  return figure(chart.id, chart.title, chart.note, legend, svg);
}

std::string draw_chart(const BarChart& chart) {
  constexpr double kBar = 18, kStep = 28;
  size_t longest = 0, longest_total = 0;
  std::vector<double> sums;
  for (const BarChart::Bar& bar : chart.bars) {
    longest = std::max(longest, bar.name.size());
    longest_total = std::max(longest_total, bar.total.size());
    double sum = 0;
    for (const double value : bar.values) sum += value;
    sums.push_back(sum);
  }
  if (chart.reference) sums.push_back(chart.reference->value);
  const double height = 14 + kStep * static_cast<double>(chart.bars.size()) + 52;
  const Area area{12 + kDigit * static_cast<double>(longest), 6,
                  kWidth - 12 - kDigit * static_cast<double>(longest_total), height - 50};
  const ChartAxis axis{chart.axis_title};
  const Scale scale(axis, std::move(sums), area.left, area.right);

  std::string legend;
  for (size_t i = 0; i < chart.parts.size(); ++i) legend += legend_entry(i, chart.parts[i], true);
  legend += reference_entry(chart.reference);
  std::string svg = begin_svg(chart.title, height) + draw_x_axis(scale, axis, area);
  double top = area.top + 6;
  for (const BarChart::Bar& bar : chart.bars) {
    svg += svg_text(area.left - 8, top + kBar - 4.5, bar.name, "end", "tick");
    double sum = 0;
    for (size_t i = 0; i < bar.values.size(); ++i) {
      const double left = scale(sum), right = scale(sum += bar.values[i]);
      const std::string what =
          bar.name + ", " + chart.parts[i] + ": " + with_decimals(bar.values[i], 3) + " " + chart.unit;
      svg += "<rect class=\"mark bar " + color_class(i) + "\"" +
             attributes({{"x", left}, {"y", top}, {"width", right - left}, {"height", kBar}}) + ">" +
             html_element("title", what) + "</rect>";
    }
    svg += svg_text(scale(sum) + 6, top + kBar - 4.5, bar.total, "start", "tick");
    top += kStep;
  }
  if (chart.reference) {
    const double at = scale(chart.reference->value);
    svg += svg_line(at, area.top, at, area.bottom, "reference");
  }
  return figure(chart.id, chart.title, chart.note, legend, svg + "</svg>");
}

}  // namespace psplit
