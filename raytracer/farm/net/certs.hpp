#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terravox::net {

inline constexpr int kMaxCertificate_days = 3650;

/// Makes certificates for a farm: a CA of its own where the folder has none (ca.pem, ca.key; valid
/// for ten years), and for each name NAME.pem and NAME.key. All carry the DNS name "terravox-farm"
/// beside their own, and a role (peer_certificate.hpp), which each end looks at; who listens and
/// who dials is another matter. ca.key makes more of them and is needed on no machine of the farm.
/// Keys (P-256) can be read by their owner alone. Files that are there stay as they are.
/// @param names  of small letters, digits, '-' and '.', 1 to 63 characters, not "ca"; none:
/// coordinator, worker
/// @param role   of all of them: kWorkerRole or kCoordinatorRole; empty: the name "coordinator" is
/// a coordinator's, all others are workers'
/// @param days   1 to kMaxCertificate_days
/// @throws UsageError for a name or number that is not allowed; Error when a file of such a name is
/// there or cannot be written: then this call has made none
void make_certs(const std::filesystem::path& folder, const std::vector<std::string>& names,
                int days, const std::string& role = {});

/// Adds the certificates NAME.pem of the folder to the CA's list of revoked ones, ca.crl beside
/// ca.pem, which is made where there is none. The list is to be copied beside ca.pem on each
/// machine: connections from then on are refused, and those that are there end within seconds.
/// @throws UsageError for a name that is not allowed; Error for files that cannot be read or
/// written, or that the CA has not signed
void revoke_certs(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace terravox::net
