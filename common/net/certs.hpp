#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terravox::net {

inline constexpr int kMostCertificate_days = 3650;

/// Makes certificates for a farm: a CA of its own where the folder has none (ca.pem, ca.key; valid for ten years), and for each name
/// NAME.pem and NAME.key, which do for either end. All carry the DNS name "terravox-farm" beside their own: whoever has one belongs to the
/// farm. ca.key makes more of them and is needed on no machine of the farm. Keys (P-256) can be read by their owner alone. Files that are
/// there stay as they are.
/// @param names  of small letters, digits, '-' and '.', 1 to 63 characters, not "ca"; none: coordinator, worker
/// @param days   1 to kMostCertificate_days
/// @throws UsageError for a name or number that is not allowed; Error when a file of such a name is there or cannot be written: then this
/// call has made none
void make_certs(const std::filesystem::path& folder, const std::vector<std::string>& names, int days);

}  // namespace terravox::net
