// The page removes the token from its address, so a reload requests the page without it. The tab's storage still has it.
const token = sessionStorage.getItem("token");
if (token && !location.search) location.replace(`?token=${token}`);
