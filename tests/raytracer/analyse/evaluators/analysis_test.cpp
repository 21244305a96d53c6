#include "raytracer/analyse/evaluators/analysis.hpp"

#include <algorithm>
#include <set>
#include <string_view>

#include "common/voxel/analysis.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("each analysis has terms, a row, and bands that are each measured or derived",
          "[raytracer][analyse]") {
    for (const voxel::AnalysisTerms& terms : voxel::kAnalyses) {
        INFO(terms.name);
        const analyse::Analysis& row = analyse::find_analysis(terms.kind);
        CHECK(&voxel::find_terms(terms.kind) == &terms);
        CHECK(core::from_word<core::AnalysisKind>(terms.name) == terms.kind);
        CHECK((row.make == nullptr) == (terms.kind == core::AnalysisKind::kNone));
        CHECK((terms.help.empty() || !row.bands.empty()));
        CHECK(terms.help.empty() == terms.title.empty());
        CHECK((row.bands.empty() || row.bands.back().name == analyse::kHoleBand.name));
        std::set<std::string_view> names;
        std::set<std::size_t> planes;
        for (const analyse::RasterBand& band : row.bands) {
            INFO(band.name);
            CHECK(names.insert(band.name).second);
            if (!band.is_derived)
                CHECK(planes.insert(analyse::find_plane(row.bands, band.name)).second);
        }
        CHECK(planes.size() == analyse::count_measured(row.bands));
        CHECK((planes.empty() || *planes.rbegin() + 1 == planes.size()));
        CHECK(planes.size() <= core::kMaxBands);
    }
}

TEST_CASE("fields that an analysis reads are fields of a scene", "[raytracer][analyse]") {
    const auto texts = scene::field_texts({});
    for (const voxel::AnalysisTerms& terms : voxel::kAnalyses)
        for (const std::string_view field : terms.fields) {
            INFO(terms.name << ": " << field);
            const bool is_there = std::any_of(texts.begin(), texts.end(),
                                              [&](const auto& one) { return one.path == field; });
            CHECK((field.empty() || is_there));
        }
}
