// Charts as inline SVG, each a <figure> with its title and legend. They bring no colours: the page styles .s0
// to .s7 by the variable --c, .mark, .line, .spread, .grid, .axis, .reference and .tag.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace psplit {

inline constexpr size_t kChartColors = 8;

struct ChartAxis {
  std::string title;
  bool is_logarithmic = false;
  double start = 0;       // where the axis begins that is not logarithmic
  bool is_count = false;  // no ticks between whole numbers
};

// A dashed line, horizontal, or in charts of bars vertical; the legend has its label.
struct ChartReference {
  double value = 0;
  std::string label;
};

struct ChartPoint {
  double x = 0, y = 0;
  std::string tag;    // stands beside the mark where there is room
  std::string title;  // what the mark says when it is pointed at
  struct Spread {
    double low_x, high_x, low_y, high_y;
  };
  std::optional<Spread> spread{};  // a thin line through the mark, as far as the chart goes
};

struct ChartSeries {
  std::string name;
  size_t style = 0;  // colour and shape
  bool has_line = true;
  std::vector<ChartPoint> points;  // numbers that are not finite, or not positive on a logarithmic axis, are
                                   // drawn at its beginning
};

struct XyChart {
  std::string id, title, note;  // the note stands below the title
  ChartAxis x, y;
  std::vector<ChartSeries> series;
  std::optional<ChartReference> reference{};
};

// Bars of parts, one below the other.
struct BarChart {
  struct Bar {
    std::string name;
    std::vector<double> values;  // of as many parts, from the first on
    std::string total;           // at the bar's end
  };
  std::string id, title, note, axis_title, unit;
  std::vector<std::string> parts;
  std::vector<Bar> bars;
  std::optional<ChartReference> reference{};
};

// Every point is one element of class "mark", as is every value of a bar. All text is escaped.
std::string draw_chart(const XyChart& chart);
std::string draw_chart(const BarChart& chart);

}  // namespace psplit
