#include "voxelserver/make/voxelize/points/class_choice.hpp"

#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"

using namespace terravox;
using namespace terravox::voxelize;

namespace {

/// A file of which only the classes of its points are known.
class Classified final : public pointcloud::PointSource {
public:
    explicit Classified(std::vector<std::uint8_t> classes)
        : PointSource({}), m_classes(std::move(classes)) {}

    [[nodiscard]] std::vector<pointcloud::PointRange> parts(std::uint64_t) const override {
        return {};
    }
    void read(std::span<const pointcloud::PointRange>,
              const pointcloud::PointBatchSink&) const override {}
    [[nodiscard]] std::vector<pointcloud::Point> sample(std::size_t) const override {
        std::vector<pointcloud::Point> out(m_classes.size());
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i].classification = m_classes[i];
        return out;
    }
    [[nodiscard]] bool sampled_all_over() const override { return true; }

private:
    std::vector<std::uint8_t> m_classes;
};

struct File {
    std::string crs;
    std::vector<std::uint8_t> classes{1, 2};
    std::string named_table{};  ///< of the source whose names it has
    double east = 600'000;
    double north = 5'300'000;
};

ClassTable choose(const std::vector<File>& given, LidarWorldOptions options = {}) {
    std::vector<SquareSource> files;
    std::vector<std::optional<grid::NamedSquare>> squares;
    for (const File& f : given) {
        SquareSource& file = files.emplace_back();
        file.info.path = "square.laz";
        file.info.crs = geo::Crs::from_text(f.crs);
        file.info.min = {f.east, f.north, 0};
        file.info.max = {f.east + 1000, f.north + 1000, 100};
        file.points = std::make_shared<const Classified>(f.classes);
        squares.emplace_back();
        if (!f.named_table.empty()) {
            squares.back().emplace();
            squares.back()->class_table = f.named_table;
        }
    }
    return choose_class_table(options, files, squares);
}

}  // namespace

TEST_CASE("the class table is chosen by names, system, place and classes",
          "[voxelserver][classes]") {
    struct Case {
        const char* name;
        std::vector<File> files;
        std::string table;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing known", {{"EPSG:32633"}}, "asprs"},
        {"France", {{"EPSG:2154", {1, 67}}}, "fr-lidarhd"},
        {"France, with heights", {{"EPSG:2154+5720"}}, "fr-lidarhd"},
        {"Reunion", {{"EPSG:2975", {1, 65}}}, "fr-lidarhd"},
        {"the Netherlands", {{"EPSG:28992"}, {"EPSG:7415"}}, "nl-ahn"},
        {"two systems", {{"EPSG:28992"}, {"EPSG:2154"}}, "asprs"},
        {"a name before all", {{"EPSG:2154", {1}, "si-clss"}}, "si-clss"},
        {"names of which some say nothing",
         {{"EPSG:3794"}, {"EPSG:3794", {1}, "si-lss"}},
         "si-lss"},
        {"names that differ",
         {{"EPSG:2154", {1}, "si-lss"}, {"EPSG:2154", {1}, "de-nw"}},
         "fr-lidarhd"},
        {"Slovenia, small buildings", {{"EPSG:3794", {2, 8}}}, "si-clss"},
        {"Slovenia without", {{"EPSG:3794", {2, 7}}}, "asprs"},
        {"Switzerland, one class of vegetation", {{"EPSG:2056", {2, 3}}}, "ch-swisstopo"},
        {"Switzerland, three", {{"EPSG:2056", {2, 3, 5}}}, "asprs"},
        {"Bavaria", {{"EPSG:25832", {2, 20}}}, "de-by"},
        {"Westphalia", {{"EPSG:25832", {20}, {}, 350'000, 5'700'000}}, "de-nw"},
        {"Denmark", {{"EPSG:25832", {20}, {}, 600'000, 6'200'000}}, "asprs"},
        {"Bavaria without class 20", {{"EPSG:25832", {2, 5}}}, "asprs"},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(choose(c.files).id == c.table);
    }
}

TEST_CASE("a class table that is named is taken", "[voxelserver][classes]") {
    LidarWorldOptions options;
    options.classes = "asprs";
    CHECK(choose({{"EPSG:2154", {67}}}, options).id == "asprs");
    options.classes = "none";
    CHECK_THROWS_AS(choose({{"EPSG:2154"}}, options), util::UsageError);
}

TEST_CASE("classes that a table does not name are guessed, or marked", "[voxelserver][classes]") {
    LidarWorldOptions options;
    CHECK(choose({{"EPSG:2154"}}, options).meaning[200].role == Role::kSurface);
    options.mark_unknown = true;
    CHECK(choose({{"EPSG:2154"}}, options).meaning[200].material == voxel::Material::kUnknown);
}
