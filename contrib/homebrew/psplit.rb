# The formula of psplit for Homebrew, which builds the newest state of its repository:
#
#   brew tap-new local/psplit
#   cp contrib/homebrew/psplit.rb "$(brew --repository local/psplit)/Formula/"
#   brew install --HEAD local/psplit/psplit
#
# Homebrew takes formulae of taps alone, so the first two lines make one of this machine's own.
# The addresses are examples until the repository has a public one. A release adds `url` and `sha256` of its source archive.
class Psplit < Formula
  desc "Draco meshes as balanced patches that decode in parallel"
  homepage "https://example.org/psplit"
  version "0.1.0"
  license "Apache-2.0"
  head "https://example.org/psplit.git", branch: "main"

  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "libpng"
  depends_on "meshoptimizer"
  depends_on "nlohmann-json" # headers of psplit::gltf include it
  depends_on "xxhash"
  depends_on "zstd"
  uses_from_macos "zlib"

  def install
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", "-DPSPLIT_WITH_DRACO=OFF", "-DPSPLIT_BUILD_TESTS=OFF",
           "-DPSPLIT_THREADS=STD", "-DPSPLIT_CUDA=OFF", "-DCMAKE_DISABLE_FIND_PACKAGE_TinyGLTF=ON", *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
    pkgshare.install "gltf_ext/PSPLIT_mesh_draco_patches/samples"
  end

  test do
    system bin/"gltf-psplit", "validate", pkgshare/"samples/seams.glb"
    system bin/"gltf-psplit", "decode", pkgshare/"samples/seams.glb", "plain.glb"
    assert_path_exists testpath/"plain.glb"
  end
end
