// Positions in doubles, and the origin that is subtracted from them where floats alone would lose too much. The
// origin becomes the translation of the object's node.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "mesh_files/triangulate.h"

namespace psplit {

class Losses;
struct MeshFile;

// Which origin the positions of a mesh file get.
struct OriginChoice {
  enum class By {
    kNeed,   // one is taken if floats lose more than they may, and fewer with it
    kNone,   // none
    kGiven,  // `given`
  };
  By by = By::kNeed;
  // One for all objects, or one for each. If they do not fit the file, kNeed decides.
  std::vector<PrecisePosition> given{};
  bool refuses_coarse = false;  // kNeed decides, too, if floats lose too much relative to those given
  // What floats may lose: half a step of a grid of these bits over the object, or `spare` if that is more.
  // 0 bits: positions are to be exact, so an origin is taken if it makes floats much finer.
  int bits = 14;
  double spare = 0;
  bool is_lossless = false;  // the user wants to hear of everything that floats lose
};

// The bounds of positions, and how far the nearest floats are from them.
struct PositionSpread {
  PrecisePosition low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  double loss = 0;  // of a component, at most

  void add(const PrecisePosition& position);
  void add(const PositionSpread& other);
  bool is_empty() const { return !(low[0] <= high[0]); }
  double extent() const;  // along the longest axis
};

// The origin of each object. All objects share one if that is enough for each of them: what touches then still
// touches. Otherwise objects have origins of their own. An origin is made of whole numbers, or of multiples of
// a power of two where these are too far from a small object: the differences are exact.
std::vector<PrecisePosition> choose_origins(std::span<const PositionSpread> objects,
                                            const OriginChoice& choice);
// Whether doubles say much more of these positions than floats do.
bool need_doubles(std::span<const PositionSpread> objects);
// Whether the floats there are so coarse that decimals between them mean something else.
bool is_far(const PositionSpread& object);

// Says which origins were taken, and what floats lose. `left` has what they lose after the subtraction.
void say_origins(std::span<const PositionSpread> objects, std::span<const PrecisePosition> origins, double left,
                 const OriginChoice& choice, Losses& losses);

// The nearest float, as a double. The variable is volatile because GCC 12 takes the double itself where it
// makes vectors of such conversions.
inline double rounded_to_float(double value) {
  const volatile float nearest = static_cast<float>(value);
  return double{nearest};
}
// Whether the float of each component is finite.
bool is_finite(const PrecisePosition& position);
// The position relative to the origin, in floats.
Position relative_to(const PrecisePosition& origin, const PrecisePosition& position);
// How far that is from the position that it stands for.
double lost_by(const PrecisePosition& origin, const PrecisePosition& position);
// "500001,5400001,301"
std::string origin_text(const PrecisePosition& origin);

// Makes floats of all positions in doubles (MeshFilePart::positions), and subtracts the origins that are
// chosen. Does nothing to a file of floats, unless an origin is given.
void settle_positions(MeshFile& file, const OriginChoice& choice);

}  // namespace psplit
