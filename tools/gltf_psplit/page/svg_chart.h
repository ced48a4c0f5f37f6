// Charts as inline SVG, each a <figure> with a title and a legend. The page defines all colours: it styles .s0
// to .s7 through the variable --c, and .mark, .line, .spread, .grid, .axis, .reference and .tag.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace psplit {

inline constexpr size_t kChartColors = 8;

struct ChartAxis {
  std::string title;
  bool is_logarithmic = false;
  double start = 0;       // the beginning of the axis, unless it is logarithmic
  bool is_count = false;  // ticks only at whole numbers
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
};

struct ChartSeries {
  std::string name;
  size_t style = 0;  // colour and shape
  bool has_line = true;
  std::vector<ChartPoint> points;  // values that are not finite, or not positive on a logarithmic axis, are
                                   // drawn at its beginning
};

struct XyChart {
  std::string id, title, note;  // the note is below the title
  ChartAxis x, y;
  std::vector<ChartSeries> series;
  std::optional<ChartReference> reference{};
};

// Horizontal bars, one below the other. Each consists of parts.
struct BarChart {
  struct Bar {
    std::string name;
    std::vector<double> values;  // of the first parts, in their order
    std::string total;           // text at the end of the bar
  };
  std::string id, title, note, axis_title, unit;
  std::vector<std::string> parts;
  std::vector<Bar> bars;
  std::optional<ChartReference> reference{};
};

// Each point and each value of a bar becomes one element of class "mark". All text is escaped.
std::string draw_chart(const XyChart& chart);
std::string draw_chart(const BarChart& chart);

}  // namespace psplit
