// Charts as inline SVG, each a <figure> with a title and a legend. A figure has two drawings: a wide one for
// screens and paper, and a narrow one (class "narrow") for phones, whose letters are as large. The page shows
// one of them, and defines all colours: it styles .s0 to .s4 through the variable --c, and the classes of the
// marks.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace psplit {

inline constexpr size_t kChartColors = 5;

struct ChartAxis {
  std::string title;
  bool is_logarithmic = false;  // begins and ends at the values, with some room on both sides
  double start = 0;             // the beginning of the axis, unless it is logarithmic
  bool is_count = false;        // ticks only at whole numbers
};

// A dashed line: horizontal, or vertical in a bar chart. Its label is in the legend.
struct ChartReference {
  double value = 0;
  std::string label;
};

struct ChartPoint {
  double x = 0, y = 0;
  std::string tag;    // drawn beside the mark if there is room
  std::string title;  // shown when the pointer is on the mark
  struct Spread {
    double low_x, high_x, low_y, high_y;
  };
  std::optional<Spread> spread{};  // a thin line through the mark, clipped to the chart
  bool is_noisy = false;           // gets a dashed ring
};

// No two series of a chart should have the same style. Series that have the same colour differ in shape, or in
// being hollow.
struct ChartStyle {
  size_t color = 0, shape = 0;
  bool is_hollow = false, is_dashed = false;
};

struct ChartSeries {
  std::string name;
  ChartStyle style;
  std::vector<ChartPoint> points;  // joined by a line; values that are not finite, or not positive on a
                                   // logarithmic axis, are drawn at its beginning
};

struct XyChart {
  std::string id, title, note;  // the note is below the title
  ChartAxis x, y;
  std::vector<ChartSeries> series;
  std::optional<ChartReference> reference{};
  // Not empty: draws the border of the region that points further right and lower beat, with this name.
  std::string front{};
  double width = 680, height = 380;  // of the wide drawing
};

// Horizontal bars, one below the other. Each consists of parts.
struct BarChart {
  struct Bar {
    std::string name;
    std::vector<double> values;  // of the first parts, in their order
    std::string total;           // text at the end of the bar
    std::vector<bool> noisy{};   // the values that are drawn as uncertain; may be shorter
  };
  std::string id, title, note, axis_title, unit;
  std::vector<std::string> parts;
  std::vector<Bar> bars;
  std::optional<ChartReference> reference{};
};

// Each point and each value of a bar becomes one element of class "mark" in each drawing. All text is escaped.
// `noisy` is the legend of noisy marks, which appears if there are any.
std::string draw_chart(const XyChart& chart, const std::string& noisy = "noisy");
std::string draw_chart(const BarChart& chart, const std::string& noisy = "noisy");

// The points of which no other is both at least as far right and at least as low, from left to right.
std::vector<const ChartPoint*> front_of(const XyChart& chart);

}  // namespace psplit
